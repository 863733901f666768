"""Tables of a shell description: supports, loads and probes."""

from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from ...package.specification import ShellLinkKind
from ..common.table import Table, Vector, entry, optional

Freedom = Literal["ux", "uy", "uz", "rx", "ry", "rz"]
FREEDOMS: tuple[Freedom, ...] = ("ux", "uy", "uz", "rx", "ry", "rz")
HELD: dict[str, tuple[Freedom, ...]] = {
    "all": FREEDOMS,
    "symmetry-x": ("ux", "ry", "rz"),
    "symmetry-y": ("uy", "rx", "rz"),
    "symmetry-z": ("uz", "rx", "ry"),
}
ON_CELLS = ("force_per_area", "pressure")
RESULTANTS = ("N11", "N22", "N12", "M11", "M22", "M12", "T1", "T2")
Asked = Literal[
    "ux", "uy", "uz", "rx", "ry", "rz", "N11", "N22", "N12", "M11", "M22", "M12", "T1", "T2"
]


def _as_list(value: object) -> object:
    """Accept one name instead of a list of one."""
    return [value] if isinstance(value, str) else value


LINKS = (
    "rigid: group and point move as a rigid body; average: the point follows the mean motion "
    "of the group, and its loads are distributed over the group; section: its loads are the "
    "stresses in the walls of a thin-walled section, for an open end: a curve"
)


class Link(Table):
    """`[links.NAME]`: a reference point of six degrees of freedom for a group of nodes."""

    at: str | Annotated[list[str], Field(min_length=1)] = entry(
        "physical point, curve or surface, or names of several of one kind"
    )
    kind: ShellLinkKind = entry(LINKS)
    point: Vector | None = optional("the reference point; absent: centre of the group", "m")


class Support(Table):
    """`[supports.NAME]`: degrees of freedom fixed to 0."""

    at: str | Annotated[list[str], Field(min_length=1)] = entry(
        "physical point, curve or surface, names of several of one kind, or a link"
    )
    fixed: (
        Literal["all", "symmetry-x", "symmetry-y", "symmetry-z"]
        | Annotated[list[Freedom], Field(min_length=1)]
    ) = entry(
        "displacements and rotations along and about x, y, z; symmetry-x: the plane normal to x "
        "is a plane of symmetry"
    )
    only: Literal["loads", "modes"] | None = optional(
        "loads: in load cases only, such as the prestress of buckling; modes: in natural modes "
        "and buckling only; absent: in all"
    )

    @property
    def freedoms(self) -> list[str]:
        """The degrees of freedom by name."""
        if isinstance(self.fixed, str):
            return list(HELD[self.fixed])
        return [freedom for freedom in FREEDOMS if freedom in self.fixed]


class Load(Table):
    """`[loads.CASE.NAME]`: one load of a case; one of the values below."""

    at: str | None = optional(
        "physical point, curve or surface, or a link; absent: the whole shell, for gravity, "
        "pressure and force_per_area"
    )
    force: Vector | None = optional(
        "total force, distributed by length of a curve, by area of a surface, or equally by points",
        "N",
    )
    moment: Vector | None = optional("total moment, same distribution", "N m")
    force_per_length: Vector | None = optional("on a curve", "N/m")
    force_per_area: Vector | None = optional("on a surface", "N/m2")
    pressure: float | None = optional("on a surface, along the normal e3 of its region", "Pa")
    sine: Vector | None = optional(
        "with force_per_area or pressure: [a, b, c] multiplies them by sin(pi x/a) sin(pi y/b) "
        "sin(pi z/c); a 0 omits its factor",
        "m",
    )
    gravity: Vector | None = optional("acceleration of gravity, on the whole shell", "m/s2")

    motion: Annotated[dict[Freedom, float], Field(min_length=1)] | None = optional(
        "displacement of components that a support holds, instead of 0: motion = { uz = 1e-3 }",
        "m, rad",
    )

    @model_validator(mode="after")
    def _one_load(self) -> Self:
        given = self.model_dump(exclude_none=True, exclude={"at", "sine"})
        if len(given) != 1:
            raise ValueError(
                "expected one of `force`, `moment`, `force_per_length`, `force_per_area`, "
                f"`pressure`, `gravity`, `motion`, found {', '.join(given) or 'none'}"
            )
        if "gravity" in given and self.at is not None:
            raise ValueError("expected no `at` with `gravity`: it acts on the whole shell")
        if self.at is None and not set(given) & {"gravity", *ON_CELLS}:
            raise ValueError(f"expected `at` with `{next(iter(given))}`")
        if self.sine is not None and not set(given) & set(ON_CELLS):
            raise ValueError("expected `sine` with `force_per_area` or `pressure` only")
        return self


class Probe(Table):
    """`[probes.NAME]`: values to show for each load case."""

    at: str | None = optional("physical point, curve or surface (mean value), or a link")
    near: Vector | None = optional(
        "instead: the nearest node, or for resultants the nearest cell", "m"
    )
    what: Annotated[
        list[Asked],
        Field(min_length=1),
        BeforeValidator(_as_list, json_schema_input_type=list[Asked] | Asked),
    ] = entry("displacements, rotations, or resultants in laminate axes")

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if (self.at is None) == (self.near is None):
            raise ValueError("expected either `at` or `near`")
        return self


class Frequencies(Table):
    """`[frequencies]`: natural frequencies and modes."""

    count: int = entry("number of modes, from the lowest", default=6, ge=1, le=1000)
    free: bool = entry("true: without the supports; six frequencies are then 0", default=False)
    prestress: str | None = optional(
        "name of a load case: the modes of the shell under its stresses"
    )
    error: bool | None = optional(
        "whether to estimate the errors of the mesh, by a mesh of half the cell size; absent: up "
        "to 4000 unknowns, and with `prestress`"
    )


class Buckling(Table):
    """`[buckling]`: load factors of linear buckling, also with `--buckling`."""

    count: int = entry("of factors of each load case", default=4, ge=1, le=100)
    cases: list[str] | None = optional("load cases that are multiplied; absent: all but `constant`")
    constant: str | None = optional("load case whose stresses are there and are not multiplied")
    in_plane: bool = entry(
        "false: without the work of the prestress on rotations about the normal, as in tables of "
        "plates",
        default=True,
    )
    error: bool = entry(
        "whether to estimate the errors of the mesh, by a mesh of half the cell size", default=True
    )
