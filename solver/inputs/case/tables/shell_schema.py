"""Keys of shells in a case file."""

from typing import Any, Literal

from pydantic import Field

from ....package.specification import MassForm, ShellLinkKind
from ...common.table import FilePath, Name, Table, Vector, unit
from ...shell.description import MOST_REFINED, REFINE
from .body_schema import DAMPING, Deformed, Reducible
from .modes import Modes, Reference
from .section_schema import CHANGES


class ShellInterface(Table):
    """`[bodies.NAME.interfaces.NAME]` of a shell: a physical group of its mesh."""

    at: str = Field(description="physical point, curve or surface of the mesh")
    link: ShellLinkKind = Field(
        default="rigid",
        description="rigid: the group moves as a rigid body; average: the interface follows "
        "the mean motion of the group, and its loads are distributed over the group; section: its "
        "loads are the stresses in the walls of a thin-walled section, for an open end: a curve",
    )
    position: Vector | None = Field(
        default=None,
        description="reference point in the body frame; absent: centre of the group",
        json_schema_extra=unit("m"),
    )
    rotation_deg: Vector = Field(
        default=[0.0, 0.0, 0.0],
        description="rotation vector from body to interface axes",
        json_schema_extra=unit("deg"),
    )


class ShellBody(Reducible, Deformed):
    """`[bodies.NAME]` with kind = "shell": a laminated shell, its axes those of the mesh.

    Mesh, materials, laminates, regions, elements and stiffeners come from the description; its
    links, supports, loads, probes and frequencies are ignored.
    """

    kind: Literal["shell"]
    shell: FilePath = Field(
        description="path of a shell description (docs/shell-description.md), relative to the "
        "case file"
    )
    parameters: dict[str, bool | float | str | list[float]] = Field(
        default={}, description="of the mesh's script, over those of the description"
    )
    refine: int = Field(
        default=0, ge=0, le=MOST_REFINED, description=f"{REFINE}; added to that of the description"
    )
    changes: dict[str, Any] = Field(default={}, description=CHANGES)
    mass_form: MassForm = Field(
        default="consistent", description="inertia from consistent mass, or lumped (the paper)"
    )
    reference: Reference = Field(default=Reference(), description="reference condition")
    modes: list[Modes] = Field(min_length=1, description="which modes the solver gets")
    damping_ratio: float = Field(
        default=0.0, ge=0, lt=1, description=DAMPING, json_schema_extra=unit("-")
    )
    interfaces: dict[Name, ShellInterface] = Field(
        min_length=1, description="named places; some carry the reference condition"
    )
    second_order: bool = Field(
        default=False,
        description="second-order displacements of the modes, which geometric stiffening needs "
        "(docs/stiffening.md)",
    )
