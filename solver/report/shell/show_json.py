"""A shell file as plain data for programs: `plymotion shell FILE --json`."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from ...errors import InputError
from ...math.arrays import Array
from ...package.common.identity import check_provenance
from ...package.common.materials import MaterialError
from ...package.shell.cells import centres, corner_counts
from ...package.shell.io import read_shell
from ...package.shell.schema import SHELL_STRESSES, ShellFile, ShellLaminate
from .findings import CaseFindings, PlyExtreme, case_findings, stacking
from .show import not_estimated, title_of

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


def shell_json(shell: ShellFile) -> dict[str, Any]:
    """Return the numbers of a shell as plain data, SI."""
    modes = shell.modes
    table: dict[str, Any] = {
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
    if (words := shell.provenance.get("verification")) is not None:
        table["verification"] = words
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


def _listed(error: Array | None, rows: Array | slice) -> list[float] | None:
    return None if error is None else error[rows].tolist()


def _laminate(laminate: ShellLaminate) -> dict[str, Any]:
    ABD = laminate.ABD
    return {
        "stacking": stacking(laminate),
        "plies": [
            {
                "material": ply.material,
                "angle_deg": ply.angle_deg,
                "bottom": ply.bottom,
                "top": ply.top,
            }
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


def _case(shell: ShellFile, case: CaseFindings) -> dict[str, Any]:
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
        "load": case.load_G.tolist(),
        "reactions": dict(zip(shell.supports.names, reactions, strict=True)),
        "reaction_sum": case.reactions_G.tolist(),
        "imbalance": case.imbalance,
        "residual": float(shell.cases.residual[row]),
        "probes": probes,
        "plies": {
            laminate.laminate: [_ply(shell, ply) for ply in laminate.plies]
            for laminate in case.laminates
        },
        "strength_ratio": None if case.weakest is None else _finite(case.weakest[2].ratio),
    }


def _finite(ratio: float) -> float | None:
    """The ratio; None without stress, because JSON has no infinity."""
    return ratio if math.isfinite(ratio) else None


def _ply(shell: ShellFile, ply: PlyExtreme) -> dict[str, Any]:
    return {
        "ply": ply.ply,
        "material": ply.material,
        "angle_deg": ply.angle_deg,
        "stress": dict(zip(SHELL_STRESSES, ply.stress_M.tolist(), strict=True)),
        "reserves": {
            reserve.criterion: {
                "ratio": _finite(reserve.ratio),
                "mode": reserve.mode,
                "level": reserve.level,
                "at": centres(shell.mesh.nodes_G, shell.mesh.cells[[reserve.cell]])[0].tolist(),
            }
            for reserve in ply.reserves
        },
    }
