"""Materials, plies and laminates: their keys, units, bounds and checks."""

import json
from collections.abc import Iterable, Mapping
from functools import lru_cache
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, model_validator

from ...errors import unknown
from ...package.common.materials import MaterialError, material_from_dict, read_strength
from ...package.common.plausible import MIXED
from ...package.specification import PlyTable
from .input_table import Name, Table, entry, optional
from .layup import angles_of
from .published_materials import with_published


class YieldStrength(Table):
    """`[materials.NAME.strength]` of an isotropic material."""

    yield_stress: float = entry("yield stress", "Pa", gt=0)


class PlyStrength(Table):
    """`[materials.NAME.strength]` of an orthotropic material: magnitudes."""

    Xt: float = entry("along the fibre, tension", "Pa", gt=0)
    Xc: float = entry("along the fibre, compression", "Pa", gt=0)
    Yt: float = entry("across the fibre in the ply, tension", "Pa", gt=0)
    Yc: float = entry("across the fibre in the ply, compression", "Pa", gt=0)
    S12: float = entry("shear in the ply", "Pa", gt=0)
    Zt: float | None = optional("normal to the ply, tension; absent: Yt", "Pa", gt=0)
    Zc: float | None = optional("normal to the ply, compression; absent: Yc", "Pa", gt=0)
    S13: float | None = optional("shear 1-3; absent: S12", "Pa", gt=0)
    S23: float | None = optional(
        "shear 2-3; absent: 0.377 Yc, from the plane on which plies are crushed", "Pa", gt=0
    )
    F12_star: float | None = optional(
        "interaction of normal stresses in Tsai-Wu; absent: -0.5", "-", ge=-0.5, lt=1
    )


class StressLife(Table):
    """`[materials.NAME.fatigue]` of an isotropic material, or `.fibre` of an orthotropic one: S-N.

    The line is straight between the points, and beyond them, over logarithms of both. Signals of
    kind "ply_stress" of the material then have a Miner sum (docs/strength.md).
    """

    amplitude: list[float] = entry(
        "stress amplitudes (half the range), descending", "Pa", min_length=2
    )
    cycles: list[float] = entry("cycles to failure at each amplitude, ascending", "-", min_length=2)
    ultimate: float | None = optional(
        "static strength of Goodman's line: a tensile mean m makes an amplitude count as 1 / (1 -"
        " m / ultimate) times as much; absent: means have no effect",
        "Pa",
        gt=0,
    )
    limit: float | None = optional(
        "amplitude up to which cycles do no damage; absent: all do", "Pa", gt=0
    )

    @model_validator(mode="after")
    def _line(self) -> "StressLife":
        S, N = self.amplitude, self.cycles
        if len(S) != len(N):
            raise ValueError(f"expected as many cycles as amplitudes, found {len(N)} and {len(S)}")
        if S[-1] <= 0.0 or any(b >= a for a, b in pairwise(S)):
            raise ValueError(f"amplitude = {S}: expected descending stresses above 0")
        if N[0] < 1.0 or any(b <= a for a, b in pairwise(N)):
            raise ValueError(f"cycles = {N}: expected ascending numbers from 1 on")
        return self


class PlyFatigue(Table):
    """`[materials.NAME.fatigue]` of an orthotropic material: S-N lines of stresses in ply axes."""

    fibre: StressLife | None = optional("of stress 11")
    transverse: StressLife | None = optional("of stresses 22 and 33")
    shear: StressLife | None = optional("of stresses 12, 13 and 23")


class IsotropicMaterial(Table):
    """`[materials.NAME]` with kind = "isotropic"."""

    kind: Literal["isotropic"]
    E: float = entry("Young's modulus", "Pa", gt=0)
    nu: float = entry("Poisson's ratio", "-", gt=-1, lt=0.5)
    rho: float = entry("density", "kg/m3", gt=0)
    strength: YieldStrength | None = optional("strength, for the margins of recovered stresses")
    fatigue: StressLife | None = optional(
        "S-N line of any of its stresses, for Miner sums of signals"
    )


class OrthotropicMaterial(Table):
    """`[materials.NAME]` with kind = "orthotropic": axis 1 along the fibre, 3 normal to the ply."""

    kind: Literal["orthotropic"]
    E1: float = entry("modulus along the fibre", "Pa", gt=0)
    E2: float = entry("modulus across, in the ply", "Pa", gt=0)
    E3: float = entry("modulus normal to the ply", "Pa", gt=0)
    G12: float = entry("shear modulus in the ply", "Pa", gt=0)
    G13: float = entry("shear modulus 1-3", "Pa", gt=0)
    G23: float = entry("shear modulus 2-3", "Pa", gt=0)
    nu12: float = entry(
        "Poisson's ratio: contraction along 2 under tension along 1; nu12^2 < E1/E2 and the "
        "compliance positive definite",
        "-",
    )
    nu13: float = entry("Poisson's ratio 1-3", "-")
    nu23: float = entry("Poisson's ratio 2-3", "-")
    rho: float = entry("density", "kg/m3", gt=0)
    strength: PlyStrength | None = optional("strengths, for the margins of recovered stresses")
    fatigue: PlyFatigue | None = optional("S-N lines of its stresses, for Miner sums of signals")


class PublishedMaterial(Table):
    """`[materials.NAME]` with `library`: published values (`plymotion materials`).

    Other keys of the material replace those values, or add what the source does not give, such as
    `rho`. NAME = "as4-3501-6" in `[materials]` is short for a table with `library` alone.
    """

    model_config = ConfigDict(extra="allow")

    library: str = entry("name of a material of the library")


Material = Annotated[
    Annotated[IsotropicMaterial | OrthotropicMaterial, Field(discriminator="kind")],
    BeforeValidator(
        with_published,
        json_schema_input_type=IsotropicMaterial | OrthotropicMaterial | PublishedMaterial | str,
    ),
]


def plain(material: IsotropicMaterial | OrthotropicMaterial) -> dict[str, object]:
    """Return what bodies depend on of a material as plain data in SI, without absent keys."""
    return material.model_dump(exclude_none=True, exclude={"fatigue"})


def check_materials(materials: Mapping[str, IsotropicMaterial | OrthotropicMaterial]) -> list[str]:
    """Return errors of physically impossible materials, one line per material."""
    tables = {name: json.dumps(plain(material)) for name, material in materials.items()}
    return [error for name, table in tables.items() if (error := _error_of(name, table))]


@lru_cache(maxsize=256)
def _error_of(name: str, text: str) -> str:
    """Return what is wrong with a material, as JSON; members of a sweep share their materials."""
    table = json.loads(text)
    try:
        material_from_dict(table, f"materials.{name}")
        if "strength" in table:
            read_strength(table["strength"], table["kind"], f"materials.{name}.strength")
    except MaterialError as error:
        moduli = {key: value for key, value in table.items() if key[0] in "EG"}
        most = max(moduli, key=lambda key: float(moduli[key]))
        least = min(moduli, key=lambda key: float(moduli[key]))
        if moduli[least] < MIXED * moduli[most]:
            return (
                f"materials.{name}.{least} = {moduli[least]:g}: expected Pa, as {most} = "
                f"{moduli[most]:g}: in GPa?"
            )
        return str(error)
    return ""


Angle = Annotated[float, Field(ge=-90, le=90)]


def _readable(layup: str) -> str:
    angles_of(layup)
    return layup


class Ply(Table):
    """One entry of `plies`."""

    material: Name = entry("name of a material")
    angle_deg: Angle = entry(
        "fibre direction; of a section from x1 towards the layer direction, sign by `convention`; "
        "of a shell from e1 towards e2, right-handed about the normal",
        "deg",
        0.0,
    )
    thickness: float | None = optional(
        "of a section given for all plies of a laminate, or for none: the wall is divided equally",
        "m",
        gt=0,
    )
    repeat: int = entry("how many of this ply in a row", default=1, ge=1, le=1000)


class Laminate(Table):
    """`[laminates.NAME]`: plies of a section, outermost first; of a shell from BOTTOM to TOP.

    BOTTOM to TOP is along the normal of the shell. Either `plies`, or the short form of one
    material: `material` and `angles_deg` or `layup`, with `ply_thickness`, which a section may
    leave out. Plies and angles may be repeated and mirrored, in this order: layup = "[0/30]3s" is
    angles_deg = [0, 30], repeat = 3, symmetric = true.
    """

    plies: list[Ply] | None = optional("the plies in their order", min_length=1)
    material: Name | None = optional("short form: material of all plies")
    angles_deg: list[Angle] | None = optional("short form: angle of each ply", "deg", min_length=1)
    layup: Annotated[str, AfterValidator(_readable)] | None = optional(
        "instead of `angles_deg`: the angles as text, such as [0/45/-45/90]s, [±45/0_2]2s or "
        "[(0/90)_3/45]T"
    )
    ply_thickness: float | None = optional(
        "short form: thickness of each ply; of a section absent: equal shares of the wall",
        "m",
        gt=0,
    )
    repeat: int = entry("how many times the plies follow", default=1, ge=1, le=1000)
    symmetric: bool = entry("true: followed by the same plies in reverse order", default=False)

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        angles = (self.angles_deg, self.layup)
        if self.plies is not None and (self.material, *angles, self.ply_thickness) != (None,) * 4:
            raise ValueError("expected either `plies` or the short form, found keys of both")
        if self.plies is None and (self.material is None or angles.count(None) != 1):
            raise ValueError("expected `plies`, or `material` with either `angles_deg` or `layup`")
        if self.layup is not None and (self.repeat > 1 or self.symmetric):
            raise ValueError("expected neither `repeat` nor `symmetric` with `layup`: [0/90]2s")
        if len({ply.thickness is None for ply in self.plies or ()}) > 1:
            raise ValueError("expected `thickness` in all plies or in none")
        return self

    def stack(self) -> list[PlyTable]:
        """Return every single ply in the order of the list, in the form for the preprocessor."""
        plies = [
            _ply(p.material, p.angle_deg, p.thickness)
            for p in self.plies or ()
            for _ in range(p.repeat)
        ] or [
            _ply(str(self.material), angle, self.ply_thickness)
            for angle in (angles_of(self.layup) if self.layup else self.angles_deg or ())
        ]
        plies *= self.repeat
        return plies + plies[::-1] if self.symmetric else plies


def _ply(material: str, angle_deg: float, thickness: float | None) -> PlyTable:
    ply: PlyTable = {"material": material, "angle_deg": angle_deg}
    return ply if thickness is None else {**ply, "thickness": thickness}


class Content(Table):
    """Of what a region is made."""

    one_of = ("laminate", "material")

    laminate: Name | None = optional("name of a laminate")
    material: Name | None = optional("name of a material: one thick ply")


def unknown_materials(key: str, names: Iterable[str], known: Iterable[str]) -> list[str]:
    """Return the errors of materials that are named at a key and not described.

    Parameters
    ----------
    key : key of the input file, for messages
    names : names of materials at the key
    known : names of the materials that are described
    """
    return [line for name in dict.fromkeys(names) for line in unknown(key, name, "material", known)]
