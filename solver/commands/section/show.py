"""The numbers of a section as text for the screen and as plain data for programs."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...math.arrays import Array
from ...package.section.schema import RESULTANTS
from .conventions import convert
from .results import SectionResults

# Entries below this share of sqrt(K_ii K_jj) are round-off: shown as 0.
ROUND_OFF = 1e-10


@dataclass(frozen=True)
class Order:
    """Names of rows and columns in one code's order."""

    resultants: tuple[str, ...]
    strains: tuple[str, ...]  # on the screen
    keys: tuple[str, ...]  # in JSON


_BEAM_FIRST = Order(
    RESULTANTS,
    ("extension", "shear 2", "shear 3", "twist", "bending 2", "bending 3"),
    ("extension", "shear2", "shear3", "twist", "bend2", "bend3"),
)
_BEAM_LAST = Order(
    ("Fx", "Fy", "Fz", "Mx", "My", "Mz"),
    ("shear x", "shear y", "extension", "bending x", "bending y", "twist"),
    ("shear_x", "shear_y", "extension", "bend_x", "bend_y", "twist"),
)


def order_of(code: str) -> Order:
    """Names in the order of a code of `conventions.CODES`."""
    return _BEAM_FIRST if code in ("plymotion", "vabs") else _BEAM_LAST


def section_json(results: SectionResults, code: str = "plymotion") -> dict[str, Any]:
    """Return the numbers as plain data; K, M and the estimate in the order of `code`.

    The centres are x2, x3 of the section in every order.
    """
    error = results.error_estimate
    return {
        "K": convert(results.K, code).tolist(),
        "M": convert(results.M, code, "mass").tolist(),
        "order": list(order_of(code).keys),
        "shear_centre": results.shear_centre.tolist(),
        "tension_centre": results.tension_centre.tolist(),
        "mass_centre": results.mass_centre.tolist(),
        "initial_curvature": None
        if results.initial_curvature is None
        else results.initial_curvature.tolist(),
        # a code's axes are a permutation and reversal of ours: magnitudes do not change
        "error_estimate": None if error is None else np.abs(convert(error, code)).tolist(),
        **({"verification": results.verification} if results.verification else {}),
        "dofs": results.dofs,
        "seconds": results.seconds,
        "warnings": list(results.warnings),
    }


def section_text(results: SectionResults, title: str = "", code: str = "plymotion") -> str:
    """Return the main results of a section, at most 100 columns wide."""
    order = order_of(code)
    signs = (
        "axes x1 along the beam, x2, x3" if code == "plymotion" else f"order and signs of {code}"
    )
    lines = [
        f"{results.name}: {title}" if title else results.name,
        "",
        f"Stiffness K about the origin, {signs}",
        *matrix_lines(convert(results.K, code), order),
        "",
        *_places(results),
        *_curvature(results),
        *_effort(results),
    ]
    lines += [f"warning [{w['code']}] {w['message']}" for w in results.warnings]
    return "\n".join(lines)


def matrix_lines(K: Array, order: Order) -> list[str]:
    """Return a stiffness with units and names of rows and columns."""
    size = np.sqrt(np.abs(np.diag(K)))
    shown = np.where(np.abs(K) < ROUND_OFF * np.outer(size, size), 0.0, K)
    units = ["1/m" if name[0] in "tb" else "-" for name in order.strains]  # twist, bending
    lines = [
        " " * 9 + "".join(f"{name:>13}" for name in order.strains),
        " " * 9 + "".join(f"{f'[{unit}]':>13}" for unit in units),
    ]
    for name, row in zip(order.resultants, shown, strict=True):
        unit = "N" if name[0] == "F" else "N m"
        numbers = "".join(f"{value:13.5e}" if value else f"{0:>13}" for value in row)
        lines.append(f"{f'{name} [{unit}]':9}{numbers}")
    return lines


def _curvature(results: SectionResults) -> list[str]:
    k = results.initial_curvature
    if k is None:
        return []
    return [f"Initial         k1 = {k[0]:g}, k2 = {k[1]:g}, k3 = {k[2]:g} rad/m"]


def _places(results: SectionResults) -> list[str]:
    M = results.M
    radius = np.sqrt(M[3, 3] / M[0, 0])  # of gyration: the size of the section

    def place(label: str, centre: Array) -> str:
        x2, x3 = (_number(value, radius) for value in centre)
        return f"{label:16}x2 = {x2} m, x3 = {x3} m"

    rotary = (
        f"M{i + 1}{j + 1} = {_number(M[i, j], np.sqrt(M[i, i] * M[j, j]))}"
        for i, j in ((3, 3), (4, 4), (5, 5), (4, 5))
    )
    return [
        place("Shear centre", results.shear_centre),
        place("Tension centre", results.tension_centre),
        place("Mass centre", results.mass_centre),
        f"{'Mass':16}{M[0, 0]:.6g} kg/m",
        f"{'Rotary inertia':16}{', '.join(rotary)} kg m",
    ]


def _number(value: float, size: float) -> str:
    return "0" if abs(value) < ROUND_OFF * size else f"{value:.6g}"


def _effort(results: SectionResults) -> list[str]:
    lines = []
    scaled = results.scaled_error
    if scaled is None:
        lines.append(f"{'Error estimate':16}not requested")
    else:
        i, j = np.unravel_index(int(np.argmax(scaled)), scaled.shape)
        names = _BEAM_FIRST.strains
        first, second = sorted((int(i), int(j)))
        entry = f"K{first + 1}{second + 1}"
        size = "itself" if i == j else f"sqrt(K{first + 1}{first + 1} K{second + 1}{second + 1})"
        what = names[first] if i == j else f"{names[first]} - {names[second]}"
        lines.append(
            f"{'Error estimate':16}{scaled[i, j]:.1e} of {size} in {entry} ({what}), less elsewhere"
        )
    if results.verification is not None:
        lines.append(f"{'Second method':16}{results.verification}")
    steps = results.refinements
    cost = f"{results.dofs} unknowns, {results.seconds:.2f} s"
    lines.append(f"{'Effort':16}{cost}" + (", refined in steps:" if len(steps) > 1 else ""))
    if len(steps) > 1:
        lines += [
            f"{'':16}{step['dofs']:>9.0f} unknowns   error {step['error']:.1e}   "
            f"after {step['seconds']:.2f} s"
            for step in steps
        ]
    return lines
