"""Laminated plates against Ritz series (peers/plate_peer.py): shear, mixed loads, spin at a hub."""

from typing import Any

import numpy as np
import pytest
from peers import plate_peer
from peers.plate_peer import X, Y
from samples.body_specs import panel_body
from samples.shell_model import laminate
from samples.shell_specs import CFRP, plate

from plymotion.preprocess.body import build_body
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem

# Buckling and spin with both DOLFINx: test_shell_buckling.py, test_shell_second_order.py.
pytestmark = pytest.mark.one_end

H = 2e-3
CLAMPED = {field: (1, 1, 1, 1) for field in range(5)}
# symmetric laminates do not move in their plane when they buckle
SIMPLE = {**CLAMPED, X: (0, 0, 1, 1), Y: (1, 1, 0, 0)}
CANTILEVER = {field: (1, 0, 0, 0) for field in range(5)}
EDGES = {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)}


def shell(angles: list[float], n: tuple[int, int], a: float, b: float) -> dict[str, Any]:
    spec = plate(n, H, a, b)
    spec["mesh"]["element"] = "quadrilateral"
    spec["materials"] = {"cfrp": CFRP}
    spec["laminates"] = {"skin": laminate("cfrp", angles, H, "5/6")}
    spec["regions"] = {"all": {"laminate": "skin", "axis": [1.0, 0.0, 0.0]}}
    return spec


def stiffness(spec: dict[str, Any]) -> Any:
    found = ShellProblem(spec).regions[0].stiffness
    C = np.zeros((8, 8))
    C[:6, :6], C[6:, 6:] = found.ABD, found.Ds
    return C


# [60] has bending and twisting coupled; tension across the compression; shear of both signs
CASES = [
    ([60.0], (-1.0, 0.5, 0.0), False),
    ([45.0, -45.0, -45.0, 45.0], (0.0, 0.0, 1.0), False),
    ([45.0, -45.0, -45.0, 45.0], (-0.5, -0.5, -1.0), True),
]


@pytest.mark.provokes("shell-mesh-coarse")
@pytest.mark.parametrize(("angles", "N", "clamped"), CASES)
def test_buckling_of_laminates_and_its_error(angles: list[float], N: Any, clamped: bool) -> None:
    a, b = 0.3, 0.2
    spec = shell(angles, (18, 12), a, b)
    supports: dict[str, Any] = {
        "flat": {"at": "plate", "fixed": ["uz", "rx", "ry"], "only": "loads"},
        "middle": {"at": "centre", "fixed": ["ux", "uy"]},
        "level": {"at": "right-middle", "fixed": ["uy"]},
    }
    loads = {}
    for edge, (x, y) in EDGES.items():
        turn = ["rx", "ry"] if clamped else ["rx" if x else "ry"]
        supports[edge] = {"at": edge, "fixed": ["uz", *turn], "only": "modes"}
        force = [N[0] * x + N[2] * y, N[2] * x + N[1] * y, 0.0]
        loads[edge] = {"at": edge, "force_per_length": force}
    spec |= {"supports": supports, "loads": {"N": loads}}
    spec["buckling"] = {"count": 1, "in_plane": False, "error": True}
    result = analyse(spec)
    found = result.buckling
    assert found is not None
    assert found.error is not None
    held = CLAMPED if clamped else SIMPLE
    exact = plate_peer.Plate(stiffness(spec), a, b, held).first_factor(N)
    error = found.factors[0] / exact - 1.0
    # from above, of second order, as its estimate from a mesh of half the cell size says
    assert 0.015 < error < 0.06
    assert found.error[0] == pytest.approx(error, rel=0.08)
    codes = {warning["code"] for warning in result.warnings} - {"laminate-unbalanced"}
    assert codes == ({"shell-mesh-coarse"} if found.error[0] > 0.05 else set())


SPINS = [([45.0, -45.0, -45.0, 45.0], 0.4, 0.2, 0.1), ([0.0, 90.0], 0.3, 0.3, 0.0)]


@pytest.mark.parametrize(("angles", "a", "b", "hub"), SPINS)
def test_spinning_laminates_at_a_hub(angles: list[float], a: float, b: float, hub: float) -> None:
    spec = shell(angles, (24, 12), a, b)
    C = stiffness(spec)
    package = build_body(panel_body(spec, 8, body="plate", second_order=True))
    second = package.second_order
    assert second is not None
    peer = plate_peer.Plate(C, a, b, CANTILEVER)
    unit = np.sqrt(C[3, 3] / (CFRP["rho"] * H * a**4))
    for spin in (0.0, 2.0 * unit, 5.0 * unit):
        K = package.stiffness - spin**2 * (
            second.Z1_B[0, 0] + hub * second.Z0_B[0]
            + second.Z1_B[1, 1] - 0.5 * b * second.Z0_B[1]
        )  # fmt: skip
        found = np.sqrt(np.linalg.eigvalsh(K)[:2])
        assert found == pytest.approx(peer.spinning(CFRP["rho"], H, spin, hub), rel=5e-3)


# isotropic square, nu = 0.3: f1 and f2 by series, times sqrt(rho h a^4/D); spin times the same
SQUARES = {
    (0.0, 0.0): (3.4707, 8.4969),
    (0.0, 2.0): (4.1006, 8.9675),
    (0.0, 10.0): (11.1934, 16.6248),
    (1.0, 2.0): (4.8029, 9.2968),
    (1.0, 10.0): (16.5988, 20.5775),
}


def test_spinning_isotropic_square() -> None:
    """Flap and twist of a square cantilever at a hub of radius 0 and a, 12 modes at rest."""
    a, h = 0.3, 3e-3
    spec = plate((16, 16), h, a, a)
    spec["mesh"]["element"] = "quadrilateral"
    C, rho = stiffness(spec), next(iter(spec["materials"].values()))["rho"]
    package = build_body(panel_body(spec, 12, body="plate", second_order=True))
    second = package.second_order
    assert second is not None
    peer = plate_peer.Plate(C, a, a, CANTILEVER)
    unit = np.sqrt(C[3, 3] / (rho * h * a**4))
    for (hub, spin), known in SQUARES.items():
        exact = peer.spinning(rho, h, spin * unit, hub * a) / unit
        assert exact == pytest.approx(known, rel=2e-5)
        stiffening = second.Z1_B[0, 0] + hub * a * second.Z0_B[0]
        stiffening = stiffening + second.Z1_B[1, 1] - 0.5 * a * second.Z0_B[1]
        K = package.stiffness - (spin * unit) ** 2 * stiffening
        found = np.sqrt(np.linalg.eigvalsh(K)[:2]) / unit
        assert found == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize(("angles", "cross"), [([0.0, 90.0], True), ([45.0, -45.0], False)])
def test_unsymmetric_laminates_by_navier(angles: list[float], cross: bool) -> None:
    """Antisymmetric cross-ply on SS-1, angle-ply on SS-2 supports: bending stretches (B).

    Navier's solutions of first-order theory, with A, B and D by hand. Reddy, Mechanics of Laminated
    Composite Plates and Shells, 2004, sections 6.4 and 6.5.
    """
    spec, pressure = shell(angles, (16, 16), 1.0, 1.0), 100.0
    sides = {"left": ("uy", "rx"), "right": ("uy", "rx"), "bottom": ("ux", "ry")}
    sides["top"] = sides["bottom"]
    if not cross:  # in the plane the other component is free
        other = {"ux": "uy", "uy": "ux"}
        sides = {name: (other[u], turn) for name, (u, turn) in sides.items()}
    spec["supports"] = {n: {"at": n, "fixed": ["uz", *fixed]} for n, fixed in sides.items()}
    spec["loads"] = {"p": {"all": {"pressure": pressure}}}
    spec["frequencies"] = {"count": 2, "error": False}
    found = analyse(spec)

    C = _by_hand(angles)
    inertia = CFRP["rho"] * np.array([H, H, H, H**3 / 12.0, H**3 / 12.0])
    hertz, middle = [], 0.0
    for m in range(1, 40):
        for n in range(1, 40):
            a, b, s = m * np.pi, n * np.pi, -1.0 if cross else 1.0
            L = np.zeros((8, 5))  # amplitudes of strains from those of u, v, w, X and Y
            L[0, 0], L[1, 1], L[2, :2] = s * a, s * b, (-s * b, -s * a)
            L[3, 3], L[4, 4], L[5, 3:], L[6, 2:4] = -a, -b, (b, a), (a, 1.0)
            L[7, [2, 4]] = b, 1.0
            K = L.T @ C @ L
            hertz.append(
                np.sqrt(np.linalg.eigvals(K / inertia[:, None]).real.min()) / (2.0 * np.pi)
            )
            load = 16.0 * pressure / (np.pi**2 * m * n) * (m % 2) * (n % 2)
            w = np.linalg.solve(K, [0.0, 0.0, load, 0.0, 0.0])[2]
            middle += w * np.sin(a / 2.0) * np.sin(b / 2.0)
    np.testing.assert_allclose(found.modes.frequencies_hz, np.sort(hertz)[:2], rtol=1.5e-2)
    assert found.modes.frequencies_hz[0] == pytest.approx(min(hertz), rel=5e-3)
    deflection = np.abs(found.cases.displacements_G[0, :, 2]).max()
    assert deflection == pytest.approx(abs(middle), rel=3e-3)


def _by_hand(angles: list[float]) -> Any:
    """A, B, D and shear stiffness (5/6) of plies of equal thickness, (8, 8)."""
    C, z = np.zeros((8, 8)), np.linspace(-H / 2.0, H / 2.0, len(angles) + 1)
    E1, E2, nu = (CFRP[key] for key in ("E1", "E2", "nu12"))
    q = 1.0 - nu**2 * E2 / E1
    Q = np.array([[E1 / q, nu * E2 / q, 0.0], [nu * E2 / q, E2 / q, 0.0], [0.0, 0.0, CFRP["G12"]]])
    for angle, low, high in zip(np.radians(angles), z[:-1], z[1:], strict=True):
        c, s = np.cos(angle), np.sin(angle)
        T = np.array(
            [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]]
        )
        for i, j, k in ((0, 0, 1), (0, 3, 2), (3, 0, 2), (3, 3, 3)):
            C[i : i + 3, j : j + 3] += T.T @ Q @ T * (high**k - low**k) / k
        turn = np.array([[c, s], [-s, c]])
        C[6:, 6:] += 5.0 / 6.0 * (high - low) * turn.T @ np.diag([CFRP["G13"], CFRP["G23"]]) @ turn
    return C
