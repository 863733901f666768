"""Blade sections in the wind from a windIO file: strips of the blade, polars by thickness."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from ...math.arrays import Array
from ...math.laws import lengths_along
from .shape import blended
from .tables import Tables
from .windio import Blade

ANGLES = np.unique(np.r_[-180.0:181.0:5.0, -30.0:30.5:0.5])  # of polars [deg]
COEFFICIENTS = ("cl", "cd", "cm")
RADIANS = 3.5  # largest angle of a polar in radians


@dataclass(frozen=True)
class Strip:
    """A part of a blade about the place `at`, a fraction of the length of its line."""

    name: str
    at: float
    r: float  # [-] of the file
    width: float  # [m]
    chord: float  # [m]
    twist_deg: float  # about the line to the tip, from body y
    offset: float  # [m] aerodynamic centre ahead of the reference axis
    polar: Array  # (n, 3) lift, drag, moment at ANGLES


def strips(
    blade: Blade, tables: Tables, top: Mapping[str, Any], line: Array, n: int
) -> list[Strip]:
    """Return n strips from root to tip, narrower towards the tip.

    Parameters
    ----------
    line : (k, 3) points of the reference axis at equal steps of r from 0 to 1 [m]

    Raises
    ------
    InputError : an airfoil without polars.
    """
    s, r = lengths_along(line), np.linspace(0.0, 1.0, len(line))
    x = np.linspace(0.0, 1.0, n + 1)
    ends = s[-1] * 0.5 * (x + np.sin(0.5 * np.pi * x))
    polars = {airfoil.name: _polar(tables, top, airfoil.name) for airfoil in blade.airfoils}
    rows = []
    for k in range(n):
        at = 0.5 * (ends[k] + ends[k + 1])
        place = float(np.interp(at, s, r))
        row = blended(blade, place, lambda one: polars[one.name])
        centre, polar = float(row[0]), row[1:].reshape(-1, len(COEFFICIENTS))
        chord = blade.chord.at(place)
        rows.append(
            Strip(
                name=f"a{k + 1:02d}",
                at=float(at / s[-1]),
                r=place,
                width=float(ends[k + 1] - ends[k]),
                chord=chord,
                twist_deg=-blade.twist.at(place),
                offset=blade.offset.at(place) - centre * chord,
                polar=polar,
            )
        )
    return rows


def _polar(tables: Tables, top: Mapping[str, Any], name: str) -> Array:
    """Return the aerodynamic centre and the coefficients of an airfoil at ANGLES, flat."""
    entries = tables.entries(top, "airfoils", required=True)
    entry = next(e for e in entries if e.get("name") == name)
    path = f"airfoils.{name}"
    centre = 0.25
    if entry.get("aerodynamic_center") is not None:
        (centre,) = tables.numbers(entry, f"{path}.aerodynamic_center", 1)
    polars = tables.entries(entry, f"{path}.polars", required=True)
    if not polars:
        raise tables.error(f"{path}.polars", "none; expected lift, drag and moment over the angle")
    sets = tables.entries(polars[0], f"{path}.polars[0].re_sets", required=True)
    if not sets:
        raise tables.error(f"{path}.polars[0].re_sets", "none; expected a Reynolds number")
    columns = []
    for key in COEFFICIENTS:
        where = f"{path}.polars[0].re_sets[0].{key}"
        curve = tables.table(sets[0], where)
        grid, values = (tables.numbers(curve, f"{where}.{part}") for part in ("grid", "values"))
        if len(grid) != len(values) or (np.diff(grid) <= 0.0).any():
            raise tables.error(where, "expected rising angles and as many values")
        angles = np.degrees(grid) if np.abs(grid).max() < RADIANS else grid
        if angles[0] > -179.0 or angles[-1] < 179.0:
            message = f"{angles[0]:g} to {angles[-1]:g} deg; expected -180 to 180"
            raise tables.error(f"{where}.grid", message)
        columns.append(PchipInterpolator(angles, values)(np.clip(ANGLES, angles[0], angles[-1])))
    return np.concatenate([[centre], np.column_stack(columns).ravel()])


def section_csv(strips: list[Strip]) -> str:
    """Return the file `table` of a rotor."""
    rows = ["place,chord,width,offset,twist_deg,polar"]
    for one in strips:
        numbers = (one.chord, one.width, one.offset, one.twist_deg)
        rows.append(",".join([one.name, *(f"{value:.8g}" for value in numbers), one.name]))
    return "\n".join([*rows, ""])


def polar_csv(strips: list[Strip]) -> str:
    """Return the file `polar_table` of a rotor."""
    rows = ["polar,alpha_deg,cl,cd,cm"]
    for one in strips:
        for angle, values in zip(ANGLES, one.polar, strict=True):
            rows.append(",".join([one.name, f"{angle:g}", *(f"{value:.6g}" for value in values)]))
    return "\n".join([*rows, ""])
