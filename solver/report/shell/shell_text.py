"""A shell file as text for the screen."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...math.arrays import Array, IntArray
from ...package.common.cells import centres, corner_counts
from ...package.shell.shell_schema import SHELL_RESULTANTS, ShellFile, ShellLaminate, ShellMeshData
from ..table import aligned, in_rows, matrix, number, rounded, warning_lines
from .findings import (
    CaseFindings,
    PlyExtreme,
    case_findings,
    centre_of,
    energy_not_estimated,
    not_estimated,
    short_stacking,
    stacking,
    title_of,
)

# Where the normals e3 of the regions of a shell point, in words: plies start at the other side.

ONE_WAY = 0.999  # length of the mean normal of a flat region
ALL = 1e-3  # share of the area that may point the other way
SHOWN = 6


def normal_lines(mesh: ShellMeshData) -> list[str]:
    """One line for each region, at most `SHOWN`."""
    places, e3 = centres(mesh.nodes_G, mesh.cells), mesh.A_GE[:, :, 2]
    lines = []
    for row, name in enumerate(mesh.regions[:SHOWN]):
        some = mesh.region == row
        if some.any():
            text = _direction(places[some], e3[some], mesh.area[some])
            lines.append(f"{'Normal e3':16}{name}: {text}")
    more = len(mesh.regions) - SHOWN
    return [*lines, f"{'':16}and {more} more"] if more > 0 else lines


def _direction(places: Array, e3: Array, area: Array) -> str:
    """Of cells with their centres (c, 3), normals (c, 3) and areas (c,)."""
    share = area / area.sum()
    mean = share @ e3
    if np.linalg.norm(mean) > ONE_WAY:
        return "({:.3g}, {:.3g}, {:.3g})".format(*(mean + 0.0).round(3))
    outwards = share[np.einsum("ci,ci->c", places - share @ places, e3) > 0.0].sum()
    if outwards > 1.0 - ALL:
        return "outwards, away from the middle of the region"
    if outwards < ALL:
        return "inwards, towards the middle of the region"
    return "varies; the file for ParaView has it"


# A shell file as text for the screen.

LINEAR_DEG = 10.0  # rotations above it give a note on linear statics
SHOWN_STRESSES = (0, 1, 5, 4, 3)  # 33 is 0
UNITS = {"u": "m", "r": "rad", "N": "N/m", "M": "N", "T": "N/m"}  # by first letter


def shell_text(shell: ShellFile) -> str:
    """Return the main results of a shell, at most 100 columns wide."""
    title = title_of(shell)
    lines = [f"{shell.name}: {title}" if title else shell.name, ""]
    lines += _mesh(shell)
    for laminate in shell.laminates:
        lines += ["", *laminate_lines(laminate)]
    for case in case_findings(shell):
        lines += ["", *_case(shell, case)]
    lines += ["", *_modes(shell), *_buckling(shell), *_bound(shell)]
    text = shell.provenance.get("verification")
    lines += [*([f"{'Second method':16}{text}"] if text else []), *_effort(shell)]
    return "\n".join([*lines, *warning_lines(shell.warnings)])


def laminate_lines(laminate: ShellLaminate) -> list[str]:
    """Return lay-up, stiffness, mass and properties of a laminate."""
    materials = list(dict.fromkeys(ply.material for ply in laminate.plies))
    bottom, top = laminate.plies[0].bottom, laminate.plies[-1].top
    return [
        f"Laminate {laminate.name}",
        f"{'Plies':16}{len(laminate.plies)}, bottom to top {_short(stacking(laminate))} of "
        f"{', '.join(materials)}",
        f"{'Thickness':16}{laminate.thickness:.6g} m, from z = {bottom:.6g} to {top:.6g} m",
        f"{'Mass':16}{laminate.mass[0]:.6g} kg/m2, first moment "
        f"{rounded(laminate.mass[1], laminate.mass[0] * laminate.thickness)} kg/m, second "
        f"{laminate.mass[2]:.6g} kg",
        *_character(laminate.report),
        "Stiffness A, B, D: N, M per unit strain and curvature",
        _matrix(laminate.ABD, SHELL_RESULTANTS[:6], ("e11", "e22", "g12", "k11", "k22", "k12")),
        "Transverse shear Ds: T per unit shear strain",
        _matrix(laminate.Ds, SHELL_RESULTANTS[6:], ("g13", "g23")),
    ]


def _short(text: str, width: int = 60) -> str:
    return text if len(text) <= width else f"{text[: width - 3]}..."


def _character(report: dict[str, object]) -> list[str]:
    lines = []
    if "symmetric" in report and "balanced" in report:
        parts = [
            "symmetric" if report["symmetric"] else "not symmetric",
            "balanced" if report["balanced"] else "not balanced",
        ]
        lines.append(f"{'Lay-up':16}{', '.join(parts)}")
    for key, label in (("membrane", "Stretching"), ("bending", "Bending")):
        of = report.get(key)
        if isinstance(of, dict):
            moduli = ", ".join(f"{name} {of[name] / 1e9:.4g} GPa" for name in ("Ex", "Ey", "Gxy"))
            lines.append(f"{label:16}{moduli}, nuxy {of['nuxy']:.4g}")
    factors = report.get("shear_factors")
    if isinstance(factors, list | tuple):
        both = ", ".join(f"{factor:.3g}" for factor in factors)
        lines.append(f'{"Shear factors":16}{both} of "energy-1d" (5/6: homogeneous)')
    return lines


def _matrix(K: Array, rows: tuple[str, ...], columns: tuple[str, ...]) -> str:
    return matrix(K, [f"{name} [{UNITS[name[0]]}]" for name in rows], columns)


def _mesh(shell: ShellFile) -> list[str]:
    mesh = shell.mesh
    mass = np.array([laminate.mass[0] for laminate in shell.laminates])
    of_cell = mass[mesh.laminate[mesh.region]]
    return [
        f"{'Mesh':16}{len(mesh.nodes_G)} nodes, {_cells(mesh.cells)} in "
        f"{_short(', '.join(mesh.regions), 50)}",
        f"{'Area, mass':16}{mesh.area.sum():.6g} m2, {of_cell @ mesh.area:.6g} kg",
        *normal_lines(mesh),
    ]


def _cells(cells: IntArray) -> str:
    """Number of cells of each kind."""
    count = corner_counts(cells)
    kinds = ((count == 3).sum(), "triangles"), ((count == 4).sum(), "quadrilaterals")
    return " and ".join(f"{number} {kind}" for number, kind in kinds if number)


def _case(shell: ShellFile, case: CaseFindings) -> list[str]:
    row = shell.cases.names.index(case.name)
    x, y, z = shell.mesh.nodes_G[case.node]
    lines = [
        f"Load case {case.name}",
        f"{'Deflection':16}at most {case.largest:.6g} m, at ({x:.4g}, {y:.4g}, {z:.4g}) m",
        f"{'Strain energy':16}{shell.cases.energy[row]:.6g} J",
        f"{'Load':16}{_six(case.load_G)}",
    ]
    if shell.cases.error is not None:
        share = round(100.0 * float(shell.cases.error[row]), 6)  # rounding is no error
        lines.insert(3, f"{'Mesh error':16}{share:+.2g} % of the strain energy, estimated")
    elif reason := energy_not_estimated(shell):
        lines.insert(3, f"{'Mesh error':16}not estimated: {reason}")
    for name, reaction in zip(shell.supports.names, shell.cases.reactions_G[row], strict=True):
        label = f"Reaction {name}"
        if len(label) > 15:
            lines.append(label)
            label = ""
        lines.append(f"{label:16}{_six(reaction)}")
    lines.append(f"{'Out of balance':16}{case.imbalance:.1e} of the load")
    if case.rotation_deg > LINEAR_DEG:
        lines.append(
            f"{'Note':16}rotations up to {case.rotation_deg:.3g} deg: this is linear statics, "
            f"valid up to about {LINEAR_DEG:g} deg"
        )
    probes = zip(shell.probes.names, shell.probes.quantities, shell.probes.values[row], strict=True)
    lines += [
        f"{'Probe':16}{name} {quantity} = {value:.6g} {UNITS[quantity[0]]}"
        for name, quantity, value in probes
    ]
    for laminate, plies in case.plies.items():
        lines += _plies(laminate, plies)
    weakest = case.weakest
    if weakest is not None and np.isfinite(weakest[2].ratio):
        laminate, ply, reserve = weakest
        x, y, z = centre_of(shell, reserve)
        lines.append(
            f"{'Least strength':16}ratio R = {reserve.ratio:.4g} by {reserve.criterion} "
            f"({reserve.mode}), {laminate} ply {ply.ply}, {reserve.place[1]},"
        )
        lines.append(f"{'':16}near ({x:.4g}, {y:.4g}, {z:.4g}) m")
    return lines


def _six(values: Array) -> str:
    size = max(float(np.abs(values).max()), np.finfo(float).tiny)
    cells = "".join(f"{rounded(value, size):>12}" for value in values)
    return f"{cells[:36]} N {cells[36:]} N m"


def _plies(laminate: str, plies: list[PlyExtreme]) -> list[str]:
    """Return the highest stress of every ply, with its least strength ratio."""
    names = ("s11", "s22", "s12", "s13", "s23")
    size = max(float(np.abs(ply.stress_M).max()) for ply in plies)
    rows = [["ply", "material", "angle", *names, "R"]]
    for ply in plies:
        least = min((reserve.ratio for reserve in ply.reserves), default=None)
        shown = [rounded(ply.stress_M[i] / 1e6, size / 1e6, 4) for i in SHOWN_STRESSES]
        own = [str(ply.ply), ply.material, f"{ply.angle_deg:.4g}"]
        rows.append([*own, *shown, number(least, 4)])
    return [
        f"Plies of {laminate}: largest stress [MPa] in ply axes, lowest strength ratio R",
        aligned(rows, (1,), head=1, rule=False),
    ]


def _modes(shell: ShellFile) -> list[str]:
    modes = shell.modes
    if modes is None:
        return []
    lines = []
    if modes.n_zero:
        lines.append(f"{'Modes':16}{modes.n_zero} without strain energy, 0 Hz")
    elastic = modes.frequencies_hz[modes.n_zero :]
    lines += in_rows("Frequencies", elastic, "Hz")
    if modes.error is not None:
        error = modes.error[modes.n_zero :]
        lines += _mesh_error(elastic, error, "frequencies", " Hz")
    elif reason := not_estimated(shell):
        lines.append(f"{'Mesh error':16}not estimated: {reason}")
    return lines


def _mesh_error(values: Array, error: Array, name: str, unit: str = "") -> list[str]:
    """Estimated errors of values, and the values without them."""
    shown = ", ".join(f"{100.0 * e:+.2g}" for e in error)
    limits = ", ".join(f"{value:.5g}" for value in values / (1.0 + error))
    return [
        f"{'Mesh error':16}{shown} %, estimated",
        f"{'':16}{name} without it {limits}{unit}",
    ]


def _buckling(shell: ShellFile) -> list[str]:
    buckling, lines = shell.buckling, []
    if buckling is None:
        return []
    for row, name in enumerate(shell.cases.names):
        factors = buckling.factors[buckling.case == row]
        back = f"; load reversed {buckling.reversed[row]:.6g}" if buckling.reversed[row] else ""
        if len(factors) or back:
            listed = ", ".join(f"{factor:.6g}" for factor in factors) or "none"
            lines.append(f"{'Load factors':16}{name}: {listed}{back}")
            if buckling.error is not None and len(factors):
                lines += _mesh_error(factors, buckling.error[buckling.case == row], "factors")
        elif row not in buckling.case:
            lines.append(f"{'Load factors':16}{name}: none, no buckling under this load")
    if buckling.error is None and len(buckling.factors):
        lines.append(f"{'Mesh error':16}not estimated")
    return lines


def _bound(shell: ShellFile) -> list[str]:
    bound = shell.provenance.get("bound")
    if bound is None:
        return []
    side, from_it = ("least", "above") if bound["of"] == "compliance" else ("most", "below")
    case = f" under {bound['case']}" if bound["case"] else ""
    kind = "symmetric lay-up" if bound["symmetric"] else "lay-up"
    other = _lay_up(bound["found_angles_deg"])
    limit, own, best = (
        f"{bound[key]:.5g} {bound['unit']}".strip() for key in ("bound", "value", "found")
    )
    own_gap, gap, rigid = (
        f"{100.0 * bound[key]:.2g} %" for key in ("gap", "found_gap", "found_gap_without_shear")
    )
    return [
        f"{'Bound':16}{bound['of']}{case}: at {side} {limit} for any {kind} of these plies",
        f"{'':16}this one {own}, at most {own_gap} {from_it} any there is",
        f"{'':16}best found {best}, at most {gap} {from_it} (without transverse shear {rigid}): "
        f"{other}",
        *_best_of_angles(bound, from_it),
    ]


def _best_of_angles(bound: Mapping[str, Any], from_it: str) -> list[str]:
    if (best := bound.get("of_angles")) is None:
        return []
    allowed = _short(", ".join(f"{angle:g}" for angle in best["allowed_deg"]), 40)
    value, gap = f"{best['best']:.5g} {bound['unit']}".strip(), f"{100.0 * best['gap']:.2g} %"
    effort = f"{best['branches']} branches, {best['computed']} of {best['lay_ups']} lay-ups"
    return [
        f"{'':16}best of {allowed} deg {value}, at most {gap} {from_it}: "
        f"{_lay_up(best['angles_deg'])}",
        f"{'':16}{effort} computed",
    ]


def _lay_up(angles_deg: Sequence[float]) -> str:
    angles = [f"{angle:g}" for angle in angles_deg]
    return _short(short_stacking(angles, mirrored=angles == angles[::-1]), 40)


def _effort(shell: ShellFile) -> list[str]:
    parts = []
    if (dofs := shell.provenance.get("dofs")) is not None:
        parts.append(f"{dofs} unknowns")
    if (seconds := shell.provenance.get("seconds")) is not None:
        parts.append(f"{seconds:.2f} s")
    return [f"{'Effort':16}{', '.join(parts)}"] if parts else []
