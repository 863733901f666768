"""Summary of a shell file: extremes of load cases, balance of forces, plies; as plain data."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from ...errors import InputError
from ...math.arrays import Array, IntArray
from ...package.common.cells import centres, corner_counts
from ...package.common.materials import MaterialError, PlyStrength, YieldStrength
from ...package.common.object_file import check_provenance
from ...package.section.stress import strengths
from ...package.shell.shell_file import read_shell
from ...package.shell.shell_schema import SHELL_STRESSES, ShellFile, ShellLaminate
from ...strength.strength_summary import Reserve, least_reserves

# The highest stresses and the least strength ratio of every ply of a laminate, over its cells.

LEVELS = ("bottom", "middle", "top")


@dataclass(frozen=True)
class PlyExtreme:
    """One ply under one load case, over all cells of its laminate."""

    ply: int  # from 0, the bottom one
    material: str
    angle_deg: float
    stress_M: Array  # (6,) of largest size, with sign: 11, 22, 33, 23, 13, 12 [Pa]
    cells: IntArray  # (6,) where
    # One for each criterion, place: cell, and one of LEVELS in the ply; none without strengths.
    reserves: tuple[Reserve, ...]


def ply_extremes(
    materials: Sequence[str],
    angles_deg: Sequence[float],
    operators: Array,
    resultants: Array,
    cells: IntArray,
    strengths: Mapping[str, PlyStrength | YieldStrength],
) -> list[PlyExtreme]:
    """Extremes of all plies of a laminate, bottom one first.

    Parameters
    ----------
    materials, angles_deg : of the k plies
    operators : (k, l, 6, r) stress in ply axes per unit resultant, at LEVELS in a shell
    resultants : (c, r) of the cells in laminate axes, in a shell N [N/m], M [N], T [N/m]
    cells : (c,) number of each cell, at least one
    strengths : of those materials that have some
    """
    extremes, levels = [], operators.shape[1]

    def place_of(row: int) -> tuple[int, str]:
        return int(cells[row // levels]), LEVELS[row % levels]

    for ply, (material, angle) in enumerate(zip(materials, angles_deg, strict=True)):
        stress = np.einsum("lij,cj->cli", operators[ply], resultants, optimize=True)
        flat = stress.reshape(-1, 6)
        largest = np.argmax(np.abs(flat), axis=0)
        reserves = least_reserves(flat, strengths.get(material), place_of)
        extremes.append(
            PlyExtreme(
                ply,
                material,
                float(angle),
                flat[largest, np.arange(6)],
                np.asarray(cells[largest // levels]),
                tuple(reserves),
            )
        )
    return extremes


# Summary of a shell file: extremes of its load cases, balance of forces, plies.

ROUNDING = 1e-6  # of the stresses across the shell: resultants below are those of balanced loads


@dataclass(frozen=True)
class CaseFindings:
    """Summary of a load case of a shell."""

    name: str
    largest: float  # |u| of the node that moves most       [m]
    node: int  # its row
    rotation_deg: float  # largest of all nodes             [deg]
    load_G: Array  # (6,) about the origin                  [N, N m]
    reactions_G: Array  # (6,) sum of all, about the origin  [N, N m]
    imbalance: float  # |load + reactions| over the larger of their parts [-]
    plies: dict[str, list[PlyExtreme]]  # of each laminate, bottom one first

    @property
    def weakest(self) -> tuple[str, PlyExtreme, Reserve] | None:
        """Laminate, ply and criterion of the least strength ratio; None without strengths."""
        known = [
            (laminate, ply, reserve)
            for laminate, plies in self.plies.items()
            for ply in plies
            for reserve in ply.reserves
        ]
        return min(known, key=lambda entry: entry[2].ratio, default=None)


def case_findings(shell: ShellFile) -> list[CaseFindings]:
    """Summarise every load case. Raises MaterialError for strengths that cannot be used."""
    known = strengths(shell)
    findings_of_cases = []
    for row, name in enumerate(shell.cases.names):
        motion = shell.cases.displacements_G[row]
        size = np.linalg.norm(motion[:, :3], axis=1)
        node = int(np.argmax(size))
        load = shell.cases.loads_G[row]
        # Sum of the reactions of all supports about the origin, (6,) [N, N m].
        each = shell.cases.reactions_G[row]
        force, moment = each[:, :3], each[:, 3:] + np.cross(shell.supports.points_G, each[:, :3])
        reactions = np.concatenate([force.sum(axis=0), moment.sum(axis=0)])
        findings_of_cases.append(
            CaseFindings(
                name,
                float(size[node]),
                node,
                float(np.degrees(np.linalg.norm(motion[:, 3:], axis=1).max(initial=0.0))),
                load,
                reactions,
                imbalance(shell, row, load, reactions),
                {shell.laminates[n].name: _plies(shell, row, n, known) for n in _used(shell)},
            )
        )
    return findings_of_cases


def imbalance(shell: ShellFile, case: int, load: Array, reactions: Array) -> float:
    """|load + reactions| over the larger of both, moments divided by the shell's size; 0 to 1.

    Loads that balance each other have neither; the force of the stresses across the shell counts.

    Parameters
    ----------
    shell : results of the shell
    case : number of the load case
    load : resultant of the loads (6,) about the origin [N, N m]
    reactions : resultant of the reactions (6,)
    """
    size = float(np.linalg.norm(np.ptp(shell.mesh.nodes_G, axis=0)))
    size += float(np.linalg.norm(shell.mesh.nodes_G, axis=1).max())  # arms about the origin
    scale = np.repeat([1.0, 1.0 / size], 3)
    membrane = float(np.abs(shell.cases.resultants_E[case, :, :3]).max(initial=0.0))
    largest = max(
        np.abs(load * scale).max(), np.abs(reactions * scale).max(), ROUNDING * membrane * size
    )
    rest = np.abs((load + reactions) * scale).max()
    return float(rest / largest) if largest > 0.0 else 0.0


def stacking(laminate: ShellLaminate) -> str:
    """The angles of a laminate in the usual short form, [0/45/-45/90]s."""
    plies = laminate.plies
    texts = [f"{ply.angle_deg:g}" for ply in plies]
    same = [
        (ply.material, ply.angle_deg, round((ply.top - ply.bottom) / laminate.thickness, 9))
        for ply in plies
    ]
    return short_stacking(texts, mirrored=same == same[::-1])


def short_stacking(texts: list[str], *, mirrored: bool) -> str:
    """The angles of plies in the usual short form."""
    n = len(texts)
    if n > 1 and n % 2 == 0 and mirrored:
        return f"[{_repeated(texts[: n // 2])}s"
    return f"[{_repeated(texts)}"


def _repeated(texts: list[str]) -> str:
    """Angles with slashes, the closing bracket and the number of repetitions."""
    n = len(texts)
    for period in range(1, n // 2 + 1):
        if n % period == 0 and texts == texts[:period] * (n // period):
            return f"{'/'.join(texts[:period])}]{n // period}"
    return f"{'/'.join(texts)}]"


def _used(shell: ShellFile) -> list[int]:
    """Rows of the laminates that have cells."""
    return sorted(set(shell.mesh.laminate[np.unique(shell.mesh.region)].tolist()))


def _plies(
    shell: ShellFile, case: int, number: int, known: Mapping[str, PlyStrength | YieldStrength]
) -> list[PlyExtreme]:
    laminate = shell.laminates[number]
    cells = np.flatnonzero(shell.mesh.laminate[shell.mesh.region] == number)
    return ply_extremes(
        [ply.material for ply in laminate.plies],
        [ply.angle_deg for ply in laminate.plies],
        laminate.stress_M,
        shell.cases.resultants_E[case, cells],
        cells,
        known,
    )


Shown = TypeVar("Shown")


def read_shown(file: Path, shown: Callable[[ShellFile], Shown]) -> tuple[ShellFile, Shown]:
    """Read a shell file; return it and what `shown` makes of it: `shell_json` or `shell_text`.

    Raises
    ------
    PackageError : not a shell file, or one that is damaged.
    InputError : a table of strengths that cannot be used.
    """
    shell = read_shell(file)
    check_provenance(file, shell.provenance)
    try:
        return shell, shown(shell)
    except MaterialError as error:
        raise InputError(f"{file}: {error}") from error


def shell_json(shell: ShellFile) -> dict[str, object]:
    """Return the numbers of a shell as plain data, SI."""
    modes = shell.modes
    table: dict[str, object] = {
        "name": shell.name,
        "title": title_of(shell),
        "nodes": len(shell.mesh.nodes_G),
        "cells": len(shell.mesh.cells),
        "triangles": int((corner_counts(shell.mesh.cells) == 3).sum()),
        "quadrilaterals": int((corner_counts(shell.mesh.cells) == 4).sum()),
        "area": float(shell.mesh.area.sum()),
        "laminates": {laminate.name: _laminate(laminate) for laminate in shell.laminates},
        "regions": {
            name: shell.laminates[row].name
            for name, row in zip(shell.mesh.regions, shell.mesh.laminate.tolist(), strict=True)
        },
        "cases": {case.name: _case(shell, case) for case in case_findings(shell)},
        "frequencies_hz": None,
        "dofs": shell.provenance.get("dofs"),
        "seconds": shell.provenance.get("seconds"),
        "warnings": list(shell.warnings),
    }
    for key in ("verification", "bound"):
        if (value := shell.provenance.get(key)) is not None:
            table[key] = value
    if modes is not None:
        table["frequencies_hz"] = modes.frequencies_hz[modes.n_zero :].tolist()
        table["zero_modes"] = modes.n_zero
        table["frequency_errors"] = _listed(modes.error, slice(modes.n_zero, None))
        table["frequency_errors_left_out"] = not_estimated(shell)
    if shell.buckling is not None:
        case = shell.buckling.case
        table["load_factors"] = {
            name: {
                "factors": shell.buckling.factors[case == row].tolist(),
                "errors": _listed(shell.buckling.error, case == row),
                "reversed": float(shell.buckling.reversed[row]) or None,
            }
            for row, name in enumerate(shell.cases.names)
        }
    return table


def title_of(shell: ShellFile) -> str:
    """The title in the description; empty if there is none."""
    spec = shell.provenance.get("spec", {})
    return str(spec.get("title", "")) if isinstance(spec, dict) else ""


def not_estimated(shell: ShellFile) -> str | None:
    """Why the errors of the frequencies are not estimated; None if they are."""
    reason = shell.provenance.get("frequency_errors")
    return str(reason) if reason else None


def energy_not_estimated(shell: ShellFile) -> str | None:
    """Why the errors of the load cases are not estimated; None if they are, or without a reason."""
    if shell.cases.error is not None or not shell.provenance.get("dofs"):
        return None
    if shell.provenance.get("verification") is None:
        return "the mesh has many unknowns; --verify does"
    return "the mesh of half the cell size is too large, or cannot be analysed"


def _listed(error: Array | None, rows: Array | slice) -> list[float] | None:
    return None if error is None else error[rows].tolist()


def _laminate(laminate: ShellLaminate) -> dict[str, object]:
    ABD = laminate.ABD
    return {
        "stacking": stacking(laminate),
        "plies": [
            {key: getattr(ply, key) for key in ("material", "angle_deg", "bottom", "top")}
            for ply in laminate.plies
        ],
        "thickness": laminate.thickness,
        "A": ABD[:3, :3].tolist(),
        "B": ABD[:3, 3:].tolist(),
        "D": ABD[3:, 3:].tolist(),
        "Ds": laminate.Ds.tolist(),
        "mass": laminate.mass.tolist(),
        "report": laminate.report,
    }


def _case(shell: ShellFile, case: CaseFindings) -> dict[str, object]:
    row = shell.cases.names.index(case.name)
    probes: dict[str, dict[str, float]] = {}
    values = shell.probes.values[row].tolist()
    for name, quantity, value in zip(
        shell.probes.names, shell.probes.quantities, values, strict=True
    ):
        probes.setdefault(name, {})[quantity] = value
    reactions = shell.cases.reactions_G[row].tolist()
    return {
        "deflection": {
            "largest": case.largest,
            "node": int(shell.mesh.node_ids[case.node]),
            "at": shell.mesh.nodes_G[case.node].tolist(),
        },
        "rotation_deg": case.rotation_deg,
        "energy": float(shell.cases.energy[row]),
        "energy_error": None if shell.cases.error is None else float(shell.cases.error[row]),
        "energy_error_left_out": energy_not_estimated(shell),
        "load": case.load_G.tolist(),
        "reactions": dict(zip(shell.supports.names, reactions, strict=True)),
        "reaction_sum": case.reactions_G.tolist(),
        "imbalance": case.imbalance,
        "residual": float(shell.cases.residual[row]),
        "probes": probes,
        "plies": {
            laminate: [_ply(shell, ply) for ply in plies] for laminate, plies in case.plies.items()
        },
        "strength_ratio": None if case.weakest is None else _finite(case.weakest[2].ratio),
    }


def centre_of(shell: ShellFile, reserve: Reserve) -> Array:
    """Centre (3,) of the cell in which a ply fails first [m]."""
    return centres(shell.mesh.nodes_G, shell.mesh.cells[[reserve.place[0]]])[0]


def _finite(ratio: float) -> float | None:
    """The ratio; None without stress, because JSON has no infinity."""
    return ratio if math.isfinite(ratio) else None


def _ply(shell: ShellFile, ply: PlyExtreme) -> dict[str, object]:
    return {
        "ply": ply.ply,
        "material": ply.material,
        "angle_deg": ply.angle_deg,
        "stress": dict(zip(SHELL_STRESSES, ply.stress_M.tolist(), strict=True)),
        "reserves": {
            reserve.criterion: {
                "ratio": _finite(reserve.ratio),
                "mode": reserve.mode,
                "level": reserve.place[1],
                "at": centre_of(shell, reserve).tolist(),
            }
            for reserve in ply.reserves
        },
    }
