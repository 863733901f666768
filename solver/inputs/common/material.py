"""Material tables: the keys, their units and bounds."""

import json
from collections.abc import Mapping
from functools import lru_cache
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from ...package.common.materials import MaterialError, material_from_dict
from ...package.common.strengths import read_strength
from .table import Table, unit


class YieldStrength(Table):
    """`[materials.NAME.strength]` of an isotropic material."""

    yield_stress: float = Field(gt=0, description="yield stress", json_schema_extra=unit("Pa"))


class PlyStrength(Table):
    """`[materials.NAME.strength]` of an orthotropic material: magnitudes."""

    Xt: float = Field(gt=0, description="along the fibre, tension", json_schema_extra=unit("Pa"))
    Xc: float = Field(
        gt=0, description="along the fibre, compression", json_schema_extra=unit("Pa")
    )
    Yt: float = Field(
        gt=0, description="across the fibre in the ply, tension", json_schema_extra=unit("Pa")
    )
    Yc: float = Field(
        gt=0, description="across the fibre in the ply, compression", json_schema_extra=unit("Pa")
    )
    S12: float = Field(gt=0, description="shear in the ply", json_schema_extra=unit("Pa"))
    Zt: float | None = Field(
        default=None,
        gt=0,
        description="normal to the ply, tension; absent: Yt",
        json_schema_extra=unit("Pa"),
    )
    Zc: float | None = Field(
        default=None,
        gt=0,
        description="normal to the ply, compression; absent: Yc",
        json_schema_extra=unit("Pa"),
    )
    S13: float | None = Field(
        default=None, gt=0, description="shear 1-3; absent: S12", json_schema_extra=unit("Pa")
    )
    S23: float | None = Field(
        default=None,
        gt=0,
        description="shear 2-3; absent: 0.377 Yc, from the plane on which plies are crushed",
        json_schema_extra=unit("Pa"),
    )
    F12_star: float | None = Field(
        default=None,
        ge=-0.5,
        lt=1,
        description="interaction of normal stresses in Tsai-Wu; absent: -0.5",
        json_schema_extra=unit("-"),
    )


class StressLife(Table):
    """`[materials.NAME.fatigue]` of an isotropic material, or `.fibre` of an orthotropic one: S-N.

    The line is straight between the points, and beyond them, over logarithms of both. Signals of
    kind "ply_stress" of the material then have a Miner sum (docs/strength.md).
    """

    amplitude: list[float] = Field(
        min_length=2,
        description="stress amplitudes (half the range), descending",
        json_schema_extra=unit("Pa"),
    )
    cycles: list[float] = Field(
        min_length=2,
        description="cycles to failure at each amplitude, ascending",
        json_schema_extra=unit("-"),
    )
    ultimate: float | None = Field(
        default=None,
        gt=0,
        description="static strength of Goodman's line: a tensile mean m makes an amplitude count "
        "as 1 / (1 - m / ultimate) times as much; absent: means have no effect",
        json_schema_extra=unit("Pa"),
    )
    limit: float | None = Field(
        default=None,
        gt=0,
        description="amplitude up to which cycles do no damage; absent: all do",
        json_schema_extra=unit("Pa"),
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

    fibre: StressLife | None = Field(default=None, description="of stress 11")
    transverse: StressLife | None = Field(default=None, description="of stresses 22 and 33")
    shear: StressLife | None = Field(default=None, description="of stresses 12, 13 and 23")


class IsotropicMaterial(Table):
    """`[materials.NAME]` with kind = "isotropic"."""

    kind: Literal["isotropic"]
    E: float = Field(gt=0, description="Young's modulus", json_schema_extra=unit("Pa"))
    nu: float = Field(gt=-1, lt=0.5, description="Poisson's ratio", json_schema_extra=unit("-"))
    rho: float = Field(gt=0, description="density", json_schema_extra=unit("kg/m3"))
    strength: YieldStrength | None = Field(
        default=None, description="strength, for the margins of recovered stresses"
    )
    fatigue: StressLife | None = Field(
        default=None, description="S-N line of any of its stresses, for Miner sums of signals"
    )


class OrthotropicMaterial(Table):
    """`[materials.NAME]` with kind = "orthotropic": axis 1 along the fibre, 3 normal to the ply."""

    kind: Literal["orthotropic"]
    E1: float = Field(gt=0, description="modulus along the fibre", json_schema_extra=unit("Pa"))
    E2: float = Field(gt=0, description="modulus across, in the ply", json_schema_extra=unit("Pa"))
    E3: float = Field(gt=0, description="modulus normal to the ply", json_schema_extra=unit("Pa"))
    G12: float = Field(gt=0, description="shear modulus in the ply", json_schema_extra=unit("Pa"))
    G13: float = Field(gt=0, description="shear modulus 1-3", json_schema_extra=unit("Pa"))
    G23: float = Field(gt=0, description="shear modulus 2-3", json_schema_extra=unit("Pa"))
    nu12: float = Field(
        description="Poisson's ratio: contraction along 2 under tension along 1; "
        "nu12^2 < E1/E2 and the compliance positive definite",
        json_schema_extra=unit("-"),
    )
    nu13: float = Field(description="Poisson's ratio 1-3", json_schema_extra=unit("-"))
    nu23: float = Field(description="Poisson's ratio 2-3", json_schema_extra=unit("-"))
    rho: float = Field(gt=0, description="density", json_schema_extra=unit("kg/m3"))
    strength: PlyStrength | None = Field(
        default=None, description="strengths, for the margins of recovered stresses"
    )
    fatigue: PlyFatigue | None = Field(
        default=None, description="S-N lines of its stresses, for Miner sums of signals"
    )


Material = Annotated[IsotropicMaterial | OrthotropicMaterial, Field(discriminator="kind")]

# In the order of a manual.
MATERIAL_TABLES: tuple[type[Table], ...] = (
    IsotropicMaterial,
    YieldStrength,
    OrthotropicMaterial,
    PlyStrength,
    PlyFatigue,
    StressLife,
)


def plain(material: IsotropicMaterial | OrthotropicMaterial) -> dict[str, Any]:
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
        return str(error)
    return ""
