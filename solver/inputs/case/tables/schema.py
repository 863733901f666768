"""Every key of a case file: type, unit, bounds and one line of meaning."""

from typing import Annotated, Any, Literal

from pydantic import Field

from ...common.material import Material
from ...common.table import Name, Table, Vector, Word, unit
from .beam_schema import BeamBody
from .body_schema import ImportedBody, PackageBody, RigidBody
from .kinds import CaseCoupling, CaseForce, CaseJoint
from .laws import TablePoints
from .section_schema import Section
from .shell_schema import ShellBody
from .signals import Signal
from .solid_schema import SolidBody
from .solver import Solver
from .sweeps import Sweep

Metric = Literal["pointwise", "extremum", "rms"]


class Fidelity(Table):
    """`[fidelity]`: the accuracy that a run must have; docs/fidelity.md."""

    accuracy: float = Field(
        gt=0, lt=1, description="accepted error of a signal, of its largest value"
    )
    signals: list[Name] | None = Field(
        default=None, min_length=1, description="the signals that must have it; absent: all"
    )
    metric: Metric = Field(
        default="pointwise",
        description="how two histories are compared: pointwise: largest difference at one time; "
        "extremum: difference of their largest and smallest values; rms: root mean square",
    )
    budget: float = Field(
        default=10.0,
        gt=0,
        description="CPU time of plan and check; no new run begins after it",
        json_schema_extra=unit("s"),
    )


Body = Annotated[
    BeamBody | ShellBody | SolidBody | RigidBody | PackageBody | ImportedBody,
    Field(discriminator="kind"),
]


class GroundPoint(Table):
    """`[ground.NAME]`: a point of the ground, used as "ground.NAME"."""

    position: Vector = Field(description="global", json_schema_extra=unit("m"))


class PointMass(Table):
    """`[masses.NAME]`: a point mass on a body."""

    mass: float = Field(gt=0, description="mass", json_schema_extra=unit("kg"))
    at: str = Field(description='"BODY.INTERFACE"')


class Mechanism(Table):
    """Keys of one run; a variant may change any of them."""

    allow: list[Literal["material-units", "size-units"]] = Field(
        default=[],
        description="warnings that are not shown, because the unusual numbers are meant",
    )
    gravity: Vector = Field(
        default=[0.0, 0.0, 0.0],
        description="acceleration of free fall, global",
        json_schema_extra=unit("m/s2"),
    )
    materials: dict[Name, Material] = Field(default={}, description="elastic materials")
    sections: dict[Name, Section] = Field(default={}, description="beam cross-sections")
    bodies: dict[Name, Body] = Field(min_length=1, description="moving bodies")
    ground: dict[Name, GroundPoint] = Field(default={}, description="points of the ground")
    joints: dict[Name, CaseJoint] = Field(default={}, description="constraints")
    couplings: dict[Name, CaseCoupling] = Field(
        default={}, description="gears, belts, screws: equations between coordinates of joints"
    )
    forces: dict[Name, CaseForce] = Field(
        default={}, description="springs, loads, stops, friction, controllers"
    )
    parameters: dict[Word, float] = Field(
        default={}, description="numbers that expressions read by name"
    )
    tables: dict[Word, TablePoints] = Field(
        default={}, description="curves through points that expressions call by name"
    )
    masses: dict[Name, PointMass] = Field(default={}, description="point masses")
    signals: dict[Name, Signal] = Field(default={}, description="what is measured")
    solver: Solver = Field(description="time integration")
    fidelity: Fidelity | None = Field(
        default=None, description="the accuracy of a run, by which its model is chosen"
    )


class Run(Table):
    """`[runs.NAME]`: one computation: the case with some variants applied in order."""

    title: str = Field(default="", description="words for figures and tables")
    variants: list[Name] = Field(default=[], description="names of variants, applied in order")


class Figure(Table):
    """`[figures.NAME]`: one signal of several runs in one picture."""

    title: str = Field(description="title of the picture")
    signal: Name = Field(description="name of a signal")
    runs: list[Name] = Field(min_length=1, description="names of runs")
    spectrum: bool = Field(
        default=False, description="amplitudes over frequency, with a Hann window, not over time"
    )


class CaseFile(Table):
    """Top-level keys of a case file, in addition to the keys of the mechanism."""

    format: Literal[1] = Field(description="version of this format")
    title: str = Field(description="one line")
    variants: dict[Name, dict[str, Any]] = Field(
        default={}, description="partial cases: tables that are merged into the case"
    )
    coarse: dict[str, Any] = Field(
        default={}, description="a variant for quick checks (`make CASE COARSE=1`), sweeps included"
    )
    runs: dict[Name, Run] = Field(min_length=1, description="what is computed")
    figures: dict[Name, Figure] = Field(default={}, description="pictures that compare runs")
    sweeps: dict[Name, Sweep] = Field(default={}, description="runs varied by numbers")
