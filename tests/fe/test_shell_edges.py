"""Buckling of laminated squares with edges of all kinds, against Ritz series (peers/plate_peer.py).

Jones' simple supports S1 to S4 differ in what they hold in the plane: S1 both displacements, S2
that along the edge (Reddy's SS-1), S3 that normal to it (SS-2), S4 none. C2 is S2 clamped, F free.
"""

from typing import Any

import numpy as np
import pytest
from peers import plate_peer
from peers.plate_peer import U, V, W, X, Y
from samples.shell_model import isotropic, laminate
from samples.shell_specs import plate
from samples.shell_squares import lamina

from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem

# Buckling with both DOLFINx: test_shell_buckling.py.
pytestmark = pytest.mark.one_end

NORMAL, ALONG = ("S1", "S3", "C1"), ("S1", "S2", "C1", "C2")
EDGES = {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)}
LOADS = {"x": (-1.0, 0.0, 0.0), "shear": (0.0, 0.0, 1.0)}

# plies, edges x = const and y = const, load, N a^2 / (E2 h^3) of the series; of [0/90] under x also
# printed by Khdeir and Reddy (1989), not re-read: 11.353, 4.851, 20.063; [0/90]5 12.092
CASES = [
    ([0.0, 90.0], "S2", "S2", "x", 11.3526),
    ([0.0, 90.0], "S2", "F", "x", 4.8507),
    ([0.0, 90.0], "S2", "C2", "x", 20.0629),
    ([0.0, 90.0] * 5, "S2", "F", "x", 12.0924),
    ([0.0, 90.0], "S3", "S3", "x", 18.5428),
    ([0.0, 90.0], "C1", "C1", "x", 25.5947),
    ([45.0, -45.0], "S3", "S3", "shear", 27.3439),
    ([45.0, -45.0], "S1", "S1", "x", 21.4989),
]


def held(edges: dict[str, str]) -> tuple[dict[str, Any], dict[int, list[int]]]:
    """Supports of buckling, and the fields that the series hold at the four edges."""
    supports: dict[str, Any] = {}
    fields = {field: [0, 0, 0, 0] for field in range(5)}
    for i, (edge, kind) in enumerate(edges.items()):
        if kind == "F":
            continue
        names = {W: "uz", U: "ux", V: "uy", X: "ry", Y: "rx"}
        own, other, turn, along = (U, V, X, Y) if i < 2 else (V, U, Y, X)
        some = [W, along]
        some += [own] if kind in NORMAL else []
        some += [other] if kind in ALONG else []
        some += [turn] if kind.startswith("C") else []
        for field in some:
            fields[field][i] = 1
        fixed = [names[field] for field in some]
        supports[edge] = {"at": edge, "fixed": fixed, "only": "modes"}
    if not any(fields[U]):
        supports["still"] = {"at": "centre", "fixed": ["ux"], "only": "modes"}
    if not any(fields[V]):
        supports["level"] = {"at": "centre", "fixed": ["uy"], "only": "modes"}
    return supports, fields


@pytest.mark.provokes("laminate-unsymmetric")
@pytest.mark.parametrize(("plies", "x", "y", "load", "printed"), CASES)
def test_edges_of_all_kinds(plies: list[float], x: str, y: str, load: str, printed: float) -> None:
    h, N = 0.1, LOADS[load]
    supports, fields = held({"left": x, "right": x, "bottom": y, "top": y})
    supports["flat"] = {"at": "plate", "fixed": ["uz", "rx", "ry"], "only": "loads"}
    supports["middle"] = {"at": "centre", "fixed": ["ux", "uy"], "only": "loads"}
    supports["turn"] = {"at": "right-middle", "fixed": ["uy"], "only": "loads"}
    loads = {
        edge: {"at": edge, "force_per_length": [N[0] * i + N[2] * j, N[2] * i + N[1] * j, 0.0]}
        for edge, (i, j) in EDGES.items()
    }
    spec = plate(16, 1.0, supports=supports, loads={"N": loads})
    spec["mesh"]["element"] = "quadrilateral"
    spec |= {
        "materials": {"ply": lamina(40.0, 0.6, 0.5)},
        "laminates": {"wall": laminate("ply", plies, h, "5/6")},
        "regions": {"all": {"laminate": "wall", "axis": [1.0, 0.0, 0.0]}},
        "buckling": {"count": 1, "in_plane": False, "error": True},
    }
    region = ShellProblem(spec).regions[0].stiffness
    C = np.zeros((8, 8))
    C[:6, :6], C[6:, 6:] = region.ABD, region.Ds
    series = plate_peer.Plate(C, 1.0, 1.0, fields)
    if not any(fields[U]):
        series.K += 1e-12 * np.mean(np.diag(series.K)) * np.eye(len(series.K))  # rigid along x
    exact = series.first_factor(N)
    assert exact / h**3 == pytest.approx(printed, rel=2e-5)
    result = analyse(spec)
    assert {warning["code"] for warning in result.warnings} == {"laminate-unsymmetric"}
    found = result.buckling
    assert found is not None
    assert found.error is not None
    assert exact < found.factors[0] < 1.035 * exact
    assert found.factors[0] / (1.0 + found.error[0]) == pytest.approx(exact, rel=5e-4)


@pytest.mark.parametrize("sides_held", [False, True])
def test_a_square_pushed_by_a_displacement(sides_held: bool) -> None:
    """k = 4, or 4 / (1 + nu) with the sides held in the plane: Nyy = nu Nxx."""
    h, nu = 0.005, 0.3
    _, materials = isotropic(1.0, nu, h)
    along = ["uy"] if sides_held else []
    supports = {
        "ends": {"at": ["left", "right"], "fixed": ["ux", "uz", "rx"]},
        "sides": {"at": ["bottom", "top"], "fixed": [*along, "uz", "ry"]},
        "level": {"at": "centre", "fixed": ["uy"]},
    }
    pushed = {"push": {"end": {"at": "right", "motion": {"ux": -1e-3}}}}
    spec = plate(8, h, supports=supports, loads=pushed, buckling={"count": 1, "error": True})
    spec["mesh"]["element"] = "quadrilateral"
    spec["materials"] = materials
    spec["regions"] = {"all": {"material": next(iter(materials)), "thickness": h}}
    found = analyse(spec).buckling
    assert found is not None
    assert found.error is not None
    strain = np.pi**2 * h**2 / 3.0 / (1.0 + nu if sides_held else 1.0 - nu**2)
    assert found.factors[0] / (1.0 + found.error[0]) * 1e-3 == pytest.approx(strain, rel=2e-3)
