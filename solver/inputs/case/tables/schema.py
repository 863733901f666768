"""Every key of a case file: type, unit, bounds and one line of meaning."""

from typing import Annotated, Any, Literal

from pydantic import Field

from ...common.material import Material
from ...common.table import Name, Table, Vector, Word, entry, optional
from .beam_schema import BeamBody
from .body_schema import ImportedBody, PackageBody, RigidBody, ShellBody, SolidBody
from .kinds import CaseCoupling, CaseForce, CaseJoint
from .laws import TablePoints
from .section_schema import Section
from .signals import Signal
from .solver import Solver
from .sweeps import Sweep

Metric = Literal["pointwise", "extremum", "rms"]


class Fidelity(Table):
    """`[fidelity]`: the accuracy that a run must have; docs/fidelity.md."""

    accuracy: float = entry("accepted error of a signal, of its largest value", gt=0, lt=1)
    signals: list[Name] | None = optional(
        "the signals that must have it; absent: all", min_length=1
    )
    metric: Metric = entry(
        "how two histories are compared: pointwise: largest difference at one time; extremum: "
        "difference of their largest and smallest values; rms: root mean square",
        default="pointwise",
    )
    budget: float = entry("CPU time of plan and check; no new run begins after it", "s", 10.0, gt=0)


Body = Annotated[
    BeamBody | ShellBody | SolidBody | RigidBody | PackageBody | ImportedBody,
    Field(discriminator="kind"),
]


class GroundPoint(Table):
    """`[ground.NAME]`: a point of the ground, used as "ground.NAME"."""

    position: Vector = entry("global", "m")


class PointMass(Table):
    """`[masses.NAME]`: a point mass on a body."""

    mass: float = entry("mass", "kg", gt=0)
    at: str = entry('"BODY.INTERFACE"')


class Mechanism(Table):
    """Keys of one run; a variant may change any of them."""

    allow: list[Literal["material-units", "size-units"]] = entry(
        "warnings that are not shown, because the unusual numbers are meant", default=[]
    )
    gravity: Vector = entry("acceleration of free fall, global", "m/s2", [0.0, 0.0, 0.0])
    materials: dict[Name, Material] = entry("elastic materials", default={})
    sections: dict[Name, Section] = entry("beam cross-sections", default={})
    bodies: dict[Name, Body] = entry("moving bodies", min_length=1)
    ground: dict[Name, GroundPoint] = entry("points of the ground", default={})
    joints: dict[Name, CaseJoint] = entry("constraints", default={})
    couplings: dict[Name, CaseCoupling] = entry(
        "gears, belts, screws: equations between coordinates of joints", default={}
    )
    forces: dict[Name, CaseForce] = entry(
        "springs, loads, stops, friction, controllers", default={}
    )
    parameters: dict[Word, float] = entry("numbers that expressions read by name", default={})
    tables: dict[Word, TablePoints] = entry(
        "curves through points that expressions call by name", default={}
    )
    masses: dict[Name, PointMass] = entry("point masses", default={})
    signals: dict[Name, Signal] = entry("what is measured", default={})
    solver: Solver = entry("time integration")
    fidelity: Fidelity | None = optional("the accuracy of a run, by which its model is chosen")


class Run(Table):
    """`[runs.NAME]`: one computation: the case with some variants applied in order."""

    title: str = entry("words for figures and tables", default="")
    variants: list[Name] = entry("names of variants, applied in order", default=[])


class Figure(Table):
    """`[figures.NAME]`: one signal of several runs in one picture."""

    title: str = entry("title of the picture")
    signal: Name = entry("name of a signal")
    runs: list[Name] = entry("names of runs", min_length=1)
    spectrum: bool = entry(
        "amplitudes over frequency, with a Hann window, not over time", default=False
    )


class CaseFile(Table):
    """Top-level keys of a case file, in addition to the keys of the mechanism."""

    format: Literal[1] = entry("version of this format")
    title: str = entry("one line")
    variants: dict[Name, dict[str, Any]] = entry(
        "partial cases: tables that are merged into the case", default={}
    )
    coarse: dict[str, Any] = entry(
        "a variant for quick checks (`make CASE COARSE=1`), sweeps included", default={}
    )
    runs: dict[Name, Run] = entry("what is computed", min_length=1)
    figures: dict[Name, Figure] = entry("pictures that compare runs", default={})
    sweeps: dict[Name, Sweep] = entry("runs varied by numbers", default={})
