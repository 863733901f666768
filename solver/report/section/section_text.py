"""Sections for the screen and for programs: stresses of plies, numbers, the table of a batch."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array
from ...package.common.files import write_text
from ...package.common.plain_data import cell_text, csv_text
from ...package.common.recovery_schema import RESULTANTS, STRESSES, Ply, SectionRecovery
from ...package.section.section_schema import SectionFile, SectionMeshData
from ...package.section.stress import near_corner, reentrant_corners, strengths
from ...strength.strength_summary import Reserve, least_reserves
from ...strength.weakest_plies import unit_stress_M
from ..table import aligned, json_text, labelled, matrix, rounded, warning_lines
from .codes import SectionResults, convert

# The highest stresses and the strength ratios of every ply under given resultants.


@dataclass(frozen=True)
class PlyPeak:
    """One ply: its highest stresses, and the first failure by each criterion."""

    ply: Ply
    stress_M: Array  # (6,) of largest size, with sign: 11, 22, 33, 23, 13, 12 [Pa]
    reserves: dict[str, Reserve]  # by criterion, place: x2, x3 [m]; empty without strengths


def ply_peaks(
    recovery: SectionRecovery, F: Array, left_out: NDArray[np.bool_] | None = None
) -> list[PlyPeak]:
    """Peak stresses and reserves of all plies, in their order.

    Parameters
    ----------
    F : (6,) F1, F2, F3, M1, M2, M3 at the reference point [N, N m]
    left_out : (p,) True for points that are not judged; absent: none

    Raises
    ------
    MaterialError : a table of strengths that cannot be used.
    """
    stress_M = unit_stress_M(recovery) @ np.asarray(F, dtype=float)
    known = strengths(recovery)
    judged = np.ones(len(recovery.ply), dtype=bool) if left_out is None else ~left_out
    peaks = []
    for row, ply in enumerate(recovery.plies):
        points = np.flatnonzero(judged & (recovery.ply == row))
        if not len(points):
            continue  # thinner than the distance between the points, or left out
        own = stress_M[points]
        largest = own[np.argmax(np.abs(own), axis=0), np.arange(6)]
        place_of = recovery.points[points].__getitem__
        reserves = least_reserves(own, known.get(ply.material), place_of)
        peaks.append(PlyPeak(ply, largest, {one.criterion: one for one in reserves}))
    return peaks


def weakest(peaks: Sequence[PlyPeak]) -> dict[str, PlyPeak]:
    """The ply with the least margin by each criterion, of the plies that it judges."""
    least: dict[str, PlyPeak] = {}
    for peak in peaks:
        for name, reserve in peak.reserves.items():
            if name not in least or reserve.ratio < least[name].reserves[name].ratio:
                least[name] = peak
    return least


def judged_peaks(
    section: SectionFile, F: Array, distance: float | None
) -> tuple[list[PlyPeak], list[dict[str, str]]]:
    """`ply_peaks` of a section, and warnings about the places of the least margins.

    Parameters
    ----------
    section : results of the section
    F : resultants (6,) [N, N m]
    distance : distance from re-entrant corners below which points are not judged [m]; None: all are
    """
    recovery, mesh = section.recovery, section.mesh
    if distance is None:
        peaks = ply_peaks(recovery, F)
        return peaks, corner_warnings(mesh, peaks)
    left_out = near_corner(mesh, recovery.points, distance)
    return ply_peaks(recovery, F, left_out), []


def corner_warnings(mesh: SectionMeshData, peaks: list[PlyPeak]) -> list[dict[str, str]]:
    """Warning if least margins lie in cells at re-entrant corners: they depend on the mesh."""
    nodes, sizes = reentrant_corners(mesh)
    if not len(nodes):
        return []
    corners = []
    for name, peak in weakest(peaks).items():
        reserve = peak.reserves[name]
        away = np.linalg.norm(mesh.nodes[nodes] - reserve.place, axis=1)
        nearest = int(np.argmin(away))
        if away[nearest] < sizes[nearest]:
            corners.append((reserve.ratio, away[nearest], nodes[nearest], name))
    if not corners:
        return []
    _, away_least, node, _ = min(corners)
    x2, x3 = mesh.nodes[node]
    names = [name for *_, name in corners]
    least = (
        f"the least margins by {', '.join(names)} lie"
        if names[1:]
        else f"the least margin by {names[0]} lies"
    )
    return [
        {
            "code": "stress-at-corner",
            "message": f"{least} at a re-entrant corner, the worst {away_least:.3g} m from "
            f"({x2:.4g}, {x3:.4g}): a finer mesh gives a smaller one; choose a distance with "
            "--corner-distance",
        }
    ]


# Stresses and margins of the plies under given resultants, as text for the screen.


def load_text(
    peaks: Sequence[PlyPeak], F: Sequence[float], warnings: Sequence[Mapping[str, str]] = ()
) -> str:
    """Return the highest stress of every ply under resultants F, its smallest margins, warnings.

    Parameters
    ----------
    peaks : highest stress of each ply
    F : resultants (6,) [N, N m]
    warnings : warnings on places of the least margins
    """
    loads = ", ".join(
        f"{name} = {value:g} {'N' if name[0] == 'F' else 'N m'}"
        for name, value in zip(RESULTANTS, F, strict=True)
    )
    rows = [["ply", "angle", *(f"s{name}" for name in STRESSES)]]
    rows += [
        [
            _ply(peak),
            f"{peak.ply.angle_deg:.4g}",
            *(f"{value:.4g}" for value in peak.stress_M / 1e6),
        ]
        for peak in peaks
    ]
    lines = [
        "Stresses of largest magnitude in each ply [MPa], in its axes, under",
        loads,
        aligned(rows, head=1, rule=False),
    ]
    return "\n".join([*lines, "", *_margins(peaks), *warning_lines(warnings)])


def _ply(peak: PlyPeak) -> str:
    return f"{peak.ply.region} {peak.ply.index} {peak.ply.material}"


def _margins(peaks: Sequence[PlyPeak]) -> list[str]:
    without = sorted({peak.ply.material for peak in peaks if not peak.reserves})
    lines = [f"No margins for {', '.join(without)}: no strengths are given"] if without else []
    least = weakest(peaks)
    if not least:
        return lines
    rows = [["ply", "angle", *least]]
    rows += [
        [_ply(p), f"{p.ply.angle_deg:.4g}", *(_margin(p.reserves.get(name)) for name in least)]
        for p in peaks
        if p.reserves
    ]
    lines += ["Margins of safety: load factor at failure minus 1"]
    lines.append(aligned(rows, head=1, rule=False))
    for name, worst in least.items():
        reserve = worst.reserves[name]
        x2, x3 = reserve.place
        lines.append(
            f"least by {name}: {reserve.ratio - 1.0:.3g} in {_ply(worst)} "
            f"({reserve.mode}) at x2 = {x2:.4g} m, x3 = {x3:.4g} m"
        )
    return lines


def _margin(reserve: Reserve | None) -> str:
    return "-" if reserve is None else f"{reserve.ratio - 1.0:.3g}"


# The numbers of a section as text for the screen and as plain data for programs.


@dataclass(frozen=True)
class ComponentNames:
    """Names of rows and columns in one code's order."""

    resultants: tuple[str, ...]
    strains: tuple[str, ...]  # on the screen
    keys: tuple[str, ...]  # in JSON


_BEAM_FIRST = ComponentNames(
    RESULTANTS,
    ("extension", "shear 2", "shear 3", "twist", "bending 2", "bending 3"),
    ("extension", "shear2", "shear3", "twist", "bend2", "bend3"),
)
_BEAM_LAST = ComponentNames(
    ("Fx", "Fy", "Fz", "Mx", "My", "Mz"),
    ("shear x", "shear y", "extension", "bending x", "bending y", "twist"),
    ("shear_x", "shear_y", "extension", "bend_x", "bend_y", "twist"),
)


def component_names(code: str) -> ComponentNames:
    """Names in the order of a code of `package.section.codes.CODES`."""
    return _BEAM_FIRST if code in ("plymotion", "vabs") else _BEAM_LAST


def section_json(results: SectionResults, code: str = "plymotion") -> dict[str, object]:
    """Return the numbers as plain data; K, M and the estimate in the order of `code`.

    The centres are x2, x3 of the section in every order.
    """
    error = results.error_estimate
    return {
        "K": convert(results.K, code).tolist(),
        "M": convert(results.M, code, "mass").tolist(),
        "order": list(component_names(code).keys),
        "shear_centre": results.shear_centre.tolist(),
        "tension_centre": results.tension_centre.tolist(),
        "mass_centre": results.mass_centre.tolist(),
        "initial_curvature": None
        if results.initial_curvature is None
        else results.initial_curvature.tolist(),
        # a code's axes are a permutation and reversal of ours: magnitudes do not change
        "error_estimate": None if error is None else np.abs(convert(error, code)).tolist(),
        **({"verification": results.verification} if results.verification else {}),
        **({"derivatives": _derivatives(results, code)} if results.design else {}),
        "dofs": results.dofs,
        "seconds": results.seconds,
        "warnings": list(results.warnings),
    }


OF_DERIVATIVES = ("shear_centre", "tension_centre", "mass_centre")


def _derivatives(results: SectionResults, code: str) -> dict[str, object]:
    """Derivatives of K, M and the centres by each parameter."""
    table: dict[str, object] = {}
    for one in results.design:
        zero = np.zeros((6, 6))
        table[one.name] = {
            "kind": one.kind,
            "K": convert(one.values.get("K", zero), code).tolist(),
            "M": convert(one.values.get("M", zero), code, "mass").tolist(),
            **{n: one.values.get(n, np.zeros(2)).tolist() for n in OF_DERIVATIVES},
        }
    return table


def _derivative_text(results: SectionResults, code: str) -> list[str]:
    order, size = component_names(code), np.sqrt(np.diag(results.K))
    lines = []
    for one in results.design:
        unit = {"angle": "deg", "thickness": "m"}.get(one.kind, "unit")
        K = one.values.get("K", np.zeros((6, 6)))
        largest = float(np.max(np.abs(K) / np.outer(size, size)))
        lines += [
            f"Derivative of K by {one.name}, per {unit}; largest entry {largest:.3g} of "
            "sqrt(Kii Kjj)",
            stiffness_text(convert(K, code), order),
        ]
        if "M" in one.values:
            lines.append(labelled("d mass", f"{one.values['M'][0, 0]:.6g} kg/m per {unit}"))
        lines.append("")
    return lines


def section_text(results: SectionResults, title: str = "", code: str = "plymotion") -> str:
    """Return the main results of a section, at most 100 columns wide.

    Parameters
    ----------
    results : results of the section
    title : title of its description
    code : program whose order and signs the matrices have
    """
    order = component_names(code)
    signs = (
        "axes x1 along the beam, x2, x3" if code == "plymotion" else f"order and signs of {code}"
    )
    lines = [
        f"{results.name}: {title}" if title else results.name,
        "",
        f"Stiffness K about the origin, {signs}",
        stiffness_text(convert(results.K, code), order),
        "",
        *_derivative_text(results, code),
        *_places(results),
        *_curvature(results),
        *_effort(results),
    ]
    return "\n".join([*lines, *warning_lines(results.warnings)])


def stiffness_text(K: Array, order: ComponentNames) -> str:
    """Return a stiffness with units and names of rows and columns."""
    names = [f"{name} [{'N' if name[0] == 'F' else 'N m'}]" for name in order.resultants]
    units = ["[1/m]" if name[0] in "tb" else "[-]" for name in order.strains]  # twist, bending
    return matrix(K, names, order.strains, units)


def _curvature(results: SectionResults) -> list[str]:
    k = results.initial_curvature
    if k is None:
        return []
    return [f"Initial         k1 = {k[0]:g}, k2 = {k[1]:g}, k3 = {k[2]:g} rad/m"]


def _places(results: SectionResults) -> list[str]:
    M = results.M
    radius = np.sqrt(M[3, 3] / M[0, 0])  # of gyration: the size of the section

    def place(label: str, centre: Array) -> str:
        x2, x3 = (rounded(value, radius, 6) for value in centre)
        return labelled(label, f"x2 = {x2} m, x3 = {x3} m")

    rotary = (
        f"M{i + 1}{j + 1} = {rounded(M[i, j], np.sqrt(M[i, i] * M[j, j]), 6)}"
        for i, j in ((3, 3), (4, 4), (5, 5), (4, 5))
    )
    return [
        place("Shear centre", results.shear_centre),
        place("Tension centre", results.tension_centre),
        place("Mass centre", results.mass_centre),
        f"{'Mass':16}{M[0, 0]:.6g} kg/m",
        f"{'Rotary inertia':16}{', '.join(rotary)} kg m",
    ]


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


SHOWN = 40  # most rows on the screen; the files have all
UPPER = [(i, j) for i in range(6) for j in range(i, 6)]


@dataclass(frozen=True)
class Row:
    """One section of a batch."""

    name: str
    status: str  # "built", "unchanged", "failed"
    changes: dict[str, object]
    results: SectionResults | None = None
    error: str = ""


def write_summary(folder: Path, stem: str, rows: Sequence[Row]) -> list[Path]:
    """Write the table as folder/stem.csv and folder/stem.json; returns the two files.

    Parameters
    ----------
    folder : folder of the files
    stem : name without ending
    rows : one row for each section
    """
    texts = {".csv": _csv(rows), ".json": json_text(summary_json(rows)) + "\n"}
    files = []
    for suffix, text in texts.items():
        files.append(folder / f"{stem}{suffix}")
        write_text(files[-1], text)
    return files


def summary_json(rows: Sequence[Row]) -> dict[str, object]:
    """Return status, changes and numbers (or the error) of each section by name."""
    return {
        row.name: {"status": row.status, "changes": row.changes}
        | (section_json(row.results) if row.results else {"error": row.error})
        for row in rows
    }


def _csv(rows: Sequence[Row]) -> str:
    keys = list(dict.fromkeys(key for row in rows for key in row.changes))
    head = ["name", "status", *keys, *(f"K{i + 1}{j + 1}" for i, j in UPPER), "mass"]
    for centre in ("mass_centre", "shear_centre", "tension_centre"):
        head += [f"{centre}_x2", f"{centre}_x3"]
    head += ["error_estimate_scaled", "dofs", "seconds", "warnings", "error"]
    lines: list[list[Any]] = [head]
    for row in rows:
        changes = [json.dumps(row.changes[key]) if key in row.changes else "" for key in keys]
        numbers = _numbers(row.results) if row.results else [""] * (len(UPPER) + 11)
        texts = cell_text(row.name), row.status, cell_text(row.error)
        lines.append([*texts[:2], *changes, *numbers, texts[2]])
    return csv_text(lines)


def _numbers(results: SectionResults) -> list[Any]:
    worst = results.worst_error
    return [
        *(results.K[i, j] for i, j in UPPER),
        results.M[0, 0],
        *results.mass_centre,
        *results.shear_centre,
        *results.tension_centre,
        "" if worst is None else worst,
        results.dofs,
        results.seconds,
        " ".join(warning["code"] for warning in results.warnings),
    ]


def summary_text(rows: Sequence[Row]) -> str:
    """Return the first rows as a table of at most 100 columns."""
    table = [
        ["name", "K11", "K44", "K55", "K66", "mass", "error", "time", ""],
        ["", "[N]", "[N m2]", "[N m2]", "[N m2]", "[kg/m]", "[-]", "[s]", ""],
    ]
    for row in rows[:SHOWN]:
        values = " ".join(json.dumps(value) for value in row.changes.values())
        table.append([_cut(row.name, 30), *_cells(row), values])
    lines = [_cut(line, 100) for line in aligned(table, (0, 8), rule=False).splitlines()]
    if len(rows) > SHOWN:
        lines.append(f"... and {len(rows) - SHOWN} more in the table")
    if any(row.results and row.results.warnings for row in rows):
        lines.append("* with warnings, see the table")
    return "\n".join(lines)


def _cut(text: str, width: int) -> str:
    return text if len(text) <= width else f"{text[: width - 1]}…"


def _cells(row: Row) -> list[str]:
    results = row.results
    if results is None:
        return ["failed", *[""] * 6]
    numbers = [f"{results.K[i, i]:.4g}" for i in (0, 3, 4, 5)]
    worst = "-" if results.worst_error is None else f"{results.worst_error:.1e}"
    star = "*" if results.warnings else ""
    return [*numbers, f"{results.M[0, 0]:.4g}", worst, f"{results.seconds:.2f}{star}"]
