"""Numbers of a solid, as a table and as text for the screen."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..package.body.package_file import read_package
from ..package.body.package_schema import ModalPackage
from ..package.common.cells import cell_table, centres
from ..package.section.stress import strengths
from ..strength.criteria.von_mises import equivalent_stress
from .shell.findings import ply_extremes
from .table import in_rows, warning_lines

# Results of a solid on the screen.


def solid_text(solid: Mapping[str, Any]) -> str:
    """Return the main results of a solid, at most 100 columns wide.

    Parameters
    ----------
    solid : as preprocess/solid/solid_analysis.py makes it, with name, seconds and warnings
    """
    lines = [
        solid["name"],
        "",
        f"{'Mesh':16}{solid['cells']} quadratic {solid['cell'].replace('dron', 'dra')} of "
        f"{solid['size']:.3g} m, {solid['unknowns']} unknowns",
        f"{'Mass':16}{solid['mass']:.6g} kg",
        f"{'Centre':16}{_row(solid['centre'])} m",
        *_inertia(solid["inertia"]),
        *_exact(solid),
        *_hertz("Free", solid["free_hz"], solid.get("free_error")),
        *(_hertz("Held", solid["held_hz"], solid.get("held_error")) if "held_hz" in solid else []),
    ]
    if reason := solid.get("no_error"):
        lines.append(f"{'Mesh error':16}not estimated: {reason}")
    for name, case in solid.get("cases", {}).items():
        lines += ["", f"Load case {name}", *_case(case)]
    lines += ["", f"{'Effort':16}{solid['seconds']:.2f} s"]
    return "\n".join([*lines, *warning_lines(solid["warnings"])])


def _row(values: list[float]) -> str:
    size = max(map(abs, values)) or 1.0
    return "".join(f"{0.0 if abs(v) < 1e-10 * size else v:14.6g}" for v in values).lstrip()


def _inertia(J: list[list[float]]) -> list[str]:
    size = float(np.abs(J).max())
    shown = [[0.0 if abs(v) < 1e-10 * size else v for v in row] for row in J]
    return [
        f"{label:16}{''.join(f'{v:14.6g}' for v in row)} kg m2"
        for label, row in zip(("Inertia", "about centre", ""), shown, strict=True)
    ]


def _exact(solid: Mapping[str, Any]) -> list[str]:
    exact = solid["exact"]
    if exact is None:
        return []
    J, JE = np.array(solid["inertia"]), np.array(exact["inertia"])
    length = float(np.sqrt(np.trace(JE) / exact["mass"]))
    gaps = (
        abs(solid["mass"] / exact["mass"] - 1.0),
        np.linalg.norm(np.subtract(solid["centre"], exact["centre"])) / length,
        np.abs(J - JE).max() / np.abs(JE).max(),
    )
    return [
        f"{'CAD geometry':16}{exact['mass']:.6g} kg; the mesh differs by {gaps[0]:.1e} in mass, "
        f"{gaps[1]:.1e} in centre, {gaps[2]:.1e} in inertia"
    ]


def _hertz(label: str, values: list[float], error: list[float] | None) -> list[str]:
    lines = in_rows(label, values, "Hz")
    if error is not None:
        shown = ", ".join(f"{100.0 * e:+.2g}" for e in error)
        lines.append(f"{'Mesh error':16}{shown} %, estimated")
    return lines


def _case(case: Mapping[str, Any]) -> list[str]:
    lines = [
        f"{'Displacement':16}at most {case['displacement']:.6g} m, at ({_place(case['at'])}) m",
        f"{'von Mises':16}at most {case['mises'] / 1e6:.5g} MPa on the surface, near "
        f"({_place(case['mises_at'])}) m",
    ]
    if "strength_ratio" in case:
        lines.append(
            f"{'Strength':16}ratio R = {case['strength_ratio']:.4g}, {case['criterion']}: "
            f"{case['mode']} of {case['material']}, near ({_place(case['strength_at'])}) m"
        )
    for name, six in case["reactions"].items():
        lines.append(f"{'Reaction ' + name:16}{_row(six[:3])} N, {_row(six[3:])} N m")
    return lines


def _place(values: list[float]) -> str:
    return ", ".join(f"{value:.4g}" for value in values)


def with_stresses(package: ModalPackage, cases: Mapping[str, Any]) -> dict[str, object]:
    """Return load cases with their largest von Mises stress and lowest strength ratio."""
    faces, stressed = package.face_stresses, dict(cases)
    if faces is None or faces.case_stress_M is None:
        return stressed
    cells = cell_table(package.connectivity, package.offsets, faces.cell)
    places, known = centres(package.nodes_B, cells), strengths(faces)
    for name, stress in zip(faces.cases, faces.case_stress_M, strict=True):
        mises = equivalent_stress(stress)
        row = int(np.argmax(mises))
        stressed[name] = cases[name] | {
            "mises": float(mises[row]),
            "mises_at": places[row].tolist(),
        }
        reserves = []
        for number, material in enumerate(sorted(faces.materials)):
            own = np.flatnonzero(faces.material == number)
            if len(own):
                six = np.eye(6)[None, None]
                (extreme,) = ply_extremes([material], [0.0], six, stress[own], own, known)
                reserves += [(reserve, material) for reserve in extreme.reserves]
        if reserves:
            least, material = min(reserves, key=lambda entry: entry[0].ratio)
            stressed[name] |= {
                "strength_ratio": least.ratio,
                "criterion": least.criterion,
                "mode": least.mode,
                "material": material,
                "strength_at": places[least.place[0]].tolist(),
            }
    return stressed


def solid_table(file: Path) -> dict[str, Any]:
    """Return the numbers of a solid from its package. Raises InputError for another package."""
    package = read_package(file)
    provenance = package.provenance
    solid = provenance.get("solid")
    if not isinstance(solid, dict) or "free_hz" not in solid:
        raise InputError(
            f"{file}: expected a package that `plymotion solid` has made; "
            "`plymotion info` shows others"
        )
    return {
        "name": file.stem,
        **solid,
        **({"cases": with_stresses(package, solid["cases"])} if "cases" in solid else {}),
        "seconds": sum(provenance["seconds"].values()),
        "warnings": list(provenance["warnings"]),
    }
