"""Every key of a file of measured modes (docs/modes.md)."""

from typing import Literal

from pydantic import Field, model_validator

from ...inputs.common.table import Name, Table, unit


class MeasuredReference(Table):
    """`[reference]`: support of the body in the test; it defines the reference condition."""

    kind: Literal["clamped", "mean-axis"] = Field(
        description="clamped: one interface was fixed to a rig; mean-axis: the body was free"
    )
    at: Name | None = Field(default=None, description="interface that was held, if clamped")

    @model_validator(mode="after")
    def _place(self) -> "MeasuredReference":
        if (self.kind == "clamped") != (self.at is not None):
            raise ValueError("expected `at` with an interface if clamped, no `at` if mean-axis")
        return self


class MeasuredMode(Table):
    """`[[modes]]`: one measured mode."""

    frequency_hz: float = Field(gt=0, description="natural frequency", json_schema_extra=unit("Hz"))
    shape: str = Field(
        description="CSV file: node, ux, uy, uz and rx, ry, rz where measured; any scale"
    )
    damping_ratio: float = Field(
        default=0.0, ge=0, lt=1, description="fraction of critical", json_schema_extra=unit("-")
    )
    label: str = Field(default="", description="name in results; absent: name of the shape's file")


class MeasuredInterface(Table):
    """`[interfaces.NAME]`: where joints, masses and signals attach."""

    nodes: list[int] = Field(
        min_length=1, description="nodes of the interface; its motion is their mean"
    )


class MeasuredFile(Table):
    """The top of the file."""

    format: Literal[1] = Field(description="version of this format")
    body: str = Field(min_length=1, description="name of the body")
    title: str = Field(default="", description="description of the test, one line")
    nodes: str = Field(
        description="CSV file: node, x, y, z [m], mass [kg] and Jxx, Jyy, Jzz, Jxy, Jxz, Jyz "
        "[kg m2] about the node where known"
    )
    lines: list[list[int]] = Field(
        default=[], description="nodes connected by lines in pictures, one list for each line"
    )
    mass_normalised: bool = Field(
        default=False, description="shapes have unit modal mass; compared with the nodal masses"
    )
    reference: MeasuredReference = Field(description="support in the test")
    modes: list[MeasuredMode] = Field(min_length=1, description="measured modes")
    interfaces: dict[Name, MeasuredInterface] = Field(min_length=1, description="named places")
