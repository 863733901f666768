"""Keys of shells in a case file."""

from typing import Any, Literal

from ....package.specification import MassForm, ShellLinkKind
from ...common.table import FilePath, Name, Table, Vector, entry, optional
from ...shell.description import MOST_REFINED, REFINE
from .body_schema import DAMPING, Deformed, Reducible
from .modes import Modes, Reference
from .section_schema import CHANGES


class ShellInterface(Table):
    """`[bodies.NAME.interfaces.NAME]` of a shell: a physical group of its mesh."""

    at: str = entry("physical point, curve or surface of the mesh")
    link: ShellLinkKind = entry(
        "rigid: the group moves as a rigid body; average: the interface follows the mean motion "
        "of the group, and its loads are distributed over the group; section: its loads are the "
        "stresses in the walls of a thin-walled section, for an open end: a curve",
        default="rigid",
    )
    position: Vector | None = optional(
        "reference point in the body frame; absent: centre of the group", "m"
    )
    rotation_deg: Vector = entry(
        "rotation vector from body to interface axes", "deg", [0.0, 0.0, 0.0]
    )


class ShellBody(Reducible, Deformed):
    """`[bodies.NAME]` with kind = "shell": a laminated shell, its axes those of the mesh.

    Mesh, materials, laminates, regions, elements and stiffeners come from the description; its
    links, supports, loads, probes and frequencies are ignored.
    """

    kind: Literal["shell"]
    shell: FilePath = entry(
        "path of a shell description (docs/shell-description.md), relative to the case file"
    )
    parameters: dict[str, bool | float | str | list[float]] = entry(
        "of the mesh's script, over those of the description", default={}
    )
    refine: int = entry(
        f"{REFINE}; added to that of the description", default=0, ge=0, le=MOST_REFINED
    )
    changes: dict[str, Any] = entry(CHANGES, default={})
    mass_form: MassForm = entry(
        "inertia from consistent mass, or lumped (the paper)", default="consistent"
    )
    reference: Reference = entry("reference condition", default=Reference())
    modes: list[Modes] = entry("which modes the solver gets", min_length=1)
    damping_ratio: float = entry(DAMPING, "-", 0.0, ge=0, lt=1)
    interfaces: dict[Name, ShellInterface] = entry(
        "named places; some carry the reference condition", min_length=1
    )
    second_order: bool = entry(
        "second-order displacements of the modes, which geometric stiffening needs "
        "(docs/stiffening.md)",
        default=False,
    )
