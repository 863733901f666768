"""Bounds over all lay-ups against closed forms of simply supported plates and random lay-ups.

Without transverse shear, a rectangular plate a x b with simply supported edges and D16 = D26 = 0
has the shapes sin(m pi x/a) sin(n pi y/b). As lambda is concave and does not change with the sign
of all angles, its maximum over mixtures is one of D16 = D26 = 0.
"""

import itertools
from typing import Any

import numpy as np
import pytest
from samples.shell_model import SCRIPTS
from samples.shell_specs import HARD, plate

from plymotion.preprocess.shell.analyses.bound import QUANTITIES, bound, turned
from plymotion.preprocess.shell.analyses.buckling import Stressed
from plymotion.preprocess.shell.analyses.cases import load_cases
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.shell_cells import ShellError

pytestmark = pytest.mark.one_end
H = 1e-3
QUADS = {"element": "quadrilateral"}
STEPS = [0, 45, -45, 90]
# Graphite-epoxy of Narita (J. Sound Vib. 263, 2003), and that of Le Riche and Haftka (AIAA J. 31,
# 1993) on their plate of 20 in by 5 in, of 48 plies of 0.005 in.
NARITA = {"E1": 138e9, "E2": 8.96e9, "G12": 7.1e9}
INCH, PSI = 0.0254, 6894.757
RICHE = {"E1": 18.5e6 * PSI, "E2": 1.89e6 * PSI, "G12": 0.93e6 * PSI}


def laminated(
    spec: dict[str, Any],
    material: dict[str, float],
    angles: Any,
    h: float,
    *,
    mirrored: bool = True,
) -> dict[str, Any]:
    """A shell of one laminate of equal plies."""
    angles = [*angles, *(angles[::-1] if mirrored else ())]
    E2, G = material["E2"], material["G12"]
    more = {"E3": E2, "G13": G, "G23": G, "nu12": 0.3, "nu13": 0.3, "nu23": 0.3, "rho": 1500.0}
    plies = [
        {"material": "ply", "angle_deg": float(a), "thickness": h / len(angles)} for a in angles
    ]
    return {
        **spec,
        "materials": {"ply": {"kind": "orthotropic", **material, **more}},
        "laminates": {"wall": {"plies": plies}},
        "regions": {"all": {"laminate": "wall", "axis": [1.0, 0.1, 0.0]}},
    }


def square(n: int, angles: Any, **tables: Any) -> dict[str, Any]:
    """A thin square with simply supported edges."""
    spec = laminated(plate(n, H, supports=HARD, **tables), NARITA, angles, H)
    spec["regions"]["all"]["axis"] = [1.0, 0.0, 0.0]
    return spec


def bending(material: dict[str, float], h: float, xi: Any) -> Any:
    """D11, D12 + 2 D66, D22 of lamination parameters of cos 2a and cos 4a."""
    ratio = 1.0 - 0.09 * material["E2"] / material["E1"]
    Q11, Q22, Q66 = material["E1"] / ratio, material["E2"] / ratio, material["G12"]
    Q12 = 0.3 * Q22
    U1 = (3.0 * (Q11 + Q22) + 2.0 * Q12 + 4.0 * Q66) / 8.0
    U2, U3 = 0.5 * (Q11 - Q22), (Q11 + Q22 - 2.0 * Q12 - 4.0 * Q66) / 8.0
    rest = (Q11 + Q22 + 6.0 * Q12 - 4.0 * Q66) / 8.0 + (Q11 + Q22 - 2.0 * Q12 + 4.0 * Q66) / 4.0
    D = [U1 + U2 * xi[0] + U3 * xi[1], rest - 3.0 * U3 * xi[1], U1 - U2 * xi[0] + U3 * xi[1]]
    return h**3 / 12.0 * np.array(D)


D0 = NARITA["E2"] * H**3 / (12.0 * (1.0 - 0.09 * NARITA["E2"] / NARITA["E1"]))


def ritz_square(angles: Any, n: int = 14) -> float:
    """Frequency parameter w a^2 sqrt(rho h / D0) of symmetric plies, by n x n double sines."""
    a = np.radians(2.0 * np.array(angles)[::-1])  # from the middle
    share = np.diff(np.arange(5.0) ** 3) / 64.0
    D11, D12_2D66, D22 = bending(NARITA, H, (share @ np.cos(a), share @ np.cos(2.0 * a)))
    Q11, Q22, Q66 = (NARITA[name] for name in ("E1", "E2", "G12"))
    Q11, Q22 = (Q / (1.0 - 0.09 * NARITA["E2"] / NARITA["E1"]) for Q in (Q11, Q22))
    U2, U3 = 0.5 * (Q11 - Q22), (Q11 + Q22 - 0.6 * Q22 - 4.0 * Q66) / 8.0
    both, apart = 0.5 * U2 * (share @ np.sin(a)), U3 * (share @ np.sin(2.0 * a))
    D16, D26 = H**3 / 12.0 * np.array([both + apart, both - apart])
    k = np.pi * np.arange(1, n + 1)
    i, j = np.meshgrid(*[np.arange(1, n + 1)] * 2, indexing="ij")
    odd = (i + j) % 2 == 1
    mixed = np.where(odd, 2.0 * i / (np.pi * np.where(odd, i**2 - j**2, 1)), 0.0)  # sin i cos j
    A, B, half = -(k[:, None] ** 2) * mixed * k, mixed * k, 0.5 * np.eye(n)
    square, fourth = np.diag(0.5 * k**2), np.diag(0.5 * k**4)
    c16, c26 = np.kron(A, B), np.kron(B, A)
    K = D11 * np.kron(fourth, half) + D22 * np.kron(half, fourth)
    K += 2.0 * D12_2D66 * np.kron(square, square)
    K += 2.0 * D16 * (c16 + c16.T) + 2.0 * D26 * (c26 + c26.T)
    return float(np.sqrt(4.0 * np.linalg.eigvalsh(K)[0] / D0))


def test_the_square_of_narita() -> None:
    """The limit of finer meshes is the closed form at xi = (0, -1); the search finds his lay-up."""
    exact = np.sqrt(np.pi**4 * bending(NARITA, H, (0.0, -1.0)) @ [1, 2, 1] / (1500.0 * H))
    spec = {"bound": "frequency", "bound_angles_deg": STEPS}
    found = [analyse({**square(n, [0, 90, 0, 90]), **spec}) for n in (8, 16)]
    coarse, fine = (each.provenance["bound"] for each in found)
    errors = [2.0 * np.pi * each["bound"] / exact - 1.0 for each in (coarse, fine)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] - (errors[0] - errors[1]) / 3.0 == pytest.approx(0.0, abs=3e-4)
    assert fine["gap"] > 0.05
    assert fine["found_gap"] < 5e-3
    angles = np.array(fine["found_angles_deg"])
    assert np.abs(angles * np.sign(angles[0])) == pytest.approx(45.0, abs=1.0)
    assert (np.sign(angles[1:7]) == -np.sign(angles[0])).all()
    best = fine["of_angles"]
    assert abs(np.array(best["angles_deg"]) @ [1, -1, -1, -1, -1, -1, -1, 1]) == 8 * 45.0
    assert (best["gap"], best["lay_ups"]) == (pytest.approx(0.0, abs=1e-4), 256)
    assert best["branches"] <= 24
    # Its frequency by Ritz's method, which falls to 56.32, and by the limit of meshes.
    ritz, unit = ritz_square([45.0, -45.0, -45.0, -45.0]), np.sqrt(1500.0 * H / D0)
    limit = (4.0 * fine["found"] - coarse["found"]) / 3.0
    assert ritz == pytest.approx(56.32, rel=5e-4)
    assert 2.0 * np.pi * limit * unit == pytest.approx(ritz, rel=1e-3)


def test_narita_s_lay_up_is_the_best_of_steps_of_45_degrees() -> None:
    """Every lay-up of eight symmetric plies of 0, 45, -45 and 90 degrees, by Ritz's method."""
    tried = {a: ritz_square(a, 6) for a in itertools.product(STEPS, repeat=4)}
    best, *others = sorted(tried, key=lambda a: -tried[a])
    assert {best, others[0]} == {(45, -45, -45, -45), (-45, 45, 45, 45)}
    assert tried[others[1]] < 0.999 * tried[best]


def test_the_panel_of_le_riche_and_haftka() -> None:
    """Ny/Nx = 1/8; without shear, as their formula of the load factor."""
    a, b, h = 20.0 * INCH, 5.0 * INCH, 48 * 0.005 * INCH
    edges = {name: {**edge, "fixed": ["uz", edge["fixed"][3]], "only": "modes"}
             for name, edge in HARD.items()}  # fmt: skip
    supports = {
        **edges,
        "flat": {"at": "plate", "fixed": ["uz", "rx", "ry"], "only": "loads"},
        "middle": {"at": "centre", "fixed": ["ux", "uy"]},
        "level": {"at": "right-middle", "fixed": ["uy"]},
    }
    push = {
        "right": [-1.0, 0, 0],
        "left": [1.0, 0, 0],
        "top": [0, -0.125, 0],
        "bottom": [0, 0.125, 0],
    }
    loads = {"N": {k: {"at": k, "force_per_length": f} for k, f in push.items()}}
    spec = plate((24, 6), h, a, b, supports=supports, loads=loads)
    spec = laminated(spec, RICHE, [45.0, -45.0] * 12, h)
    spec["regions"]["all"]["axis"] = [1.0, 0.0, 0.0]
    spec |= {"elements": {"plate": "dkt"}, "buckling": {"count": 1, "in_plane": False}}
    m, n = np.meshgrid(np.arange(1.0, 13.0), np.arange(1.0, 4.0))
    x, y = (m / a) ** 2, (n / b) ** 2

    def factor(xi: Any) -> float:
        D = bending(RICHE, h, xi)
        return float(
            (np.pi**2 * (D[0] * x**2 + 2 * D[1] * x * y + D[2] * y**2) / (x + 0.125 * y)).min()
        )

    grid = [(c, 2.0 * c * c - 1.0 + s * (2.0 - 2.0 * c * c)) for c in np.linspace(-1, 1, 81)
            for s in np.linspace(0, 1, 41)]  # fmt: skip
    exact = max(map(factor, grid))
    found = bounded({**spec, "bound_angles_deg": STEPS}, "buckling")
    assert found["bound"] == pytest.approx(exact, rel=2e-3)
    best = found["of_angles"]
    assert 0.95 * exact < best["best"] < exact
    assert best["gap"] < 1e-4
    assert best["lay_ups"] == 4**24
    assert best["branches"] <= 200
    assert found["found_gap"] < 2e-3
    assert found["gap"] > 0.02


def bounded(spec: dict[str, Any], of: str) -> dict[str, Any]:
    """The bound of a quantity."""
    return bound(stressed(ShellProblem(spec)), of, lambda _line: None)


def stressed(problem: ShellProblem) -> Stressed:
    """A shell with its load cases."""
    cases, _, u = load_cases(problem, [], lambda _line: None)
    return Stressed(problem, cases.names, u)


def panel(cells: dict[str, str], *, offset: float) -> dict[str, Any]:
    """A curved panel, clamped at one end, of four plies of no symmetry."""
    size = {"radius": 1.0, "length": 1.0, "first_deg": -30.0, "second_deg": 30.0,
            "n_length": 4, "n_around": 4}  # fmt: skip
    spec = {
        "name": "panel",
        "mesh": {"file": str(SCRIPTS / "cylinder.py"), "parameters": size, **cells},
        "supports": {"near": {"at": "near", "fixed": "all"}},
        "loads": {"q": {"p": {"at": "panel", "force_per_area": [0.0, 0.3, 1.0]}}},
    }
    spec = laminated(spec, NARITA, [45.0, -45.0, 0.0, 80.0], 0.01, mirrored=False)
    spec["laminates"]["wall"]["offset"] = offset
    return spec


@pytest.mark.parametrize("of", ["frequency", "compliance"])
@pytest.mark.parametrize("cells", [{}, QUADS], ids=["triangles", "quadrilaterals"])
def test_no_random_lay_up_is_better(of: str, cells: dict[str, str]) -> None:
    spec = panel(cells, offset=0.002)
    problem = ShellProblem(spec)
    quantity, found = QUANTITIES[of](stressed(problem), ""), bounded(spec, of)
    rng, sign = np.random.default_rng(3), -1.0 if of == "compliance" else 1.0
    values = []
    for _ in range(15):
        other = turned(problem, dict(enumerate(rng.uniform(-90.0, 90.0, 4))))
        values.append(sign * quantity.shown(float(quantity.modes(other.K)[0][0])))
    values.append(sign * found["value"])
    assert max(values) <= sign * found["found"] <= sign * found["bound"]


def clamped_square() -> dict[str, Any]:
    """A square of six plies, clamped at two edges and free at one."""
    spec = square(4, [0, 0, 0])
    fixed = {name: {"at": name, "fixed": "all"} for name in ("left", "bottom")}
    return {**spec, "supports": {**fixed, "right": HARD["right"]}}


def thin_panel() -> dict[str, Any]:
    """The curved panel with three plies, of quadrilaterals."""
    spec = panel(QUADS, offset=0.002)
    del spec["laminates"]["wall"]["plies"][3]
    return spec


@pytest.mark.parametrize(
    ("spec", "of"), [(clamped_square(), "frequency"), (thin_panel(), "compliance")]
)
def test_branch_and_bound_finds_the_best_of_all_lay_ups(spec: dict[str, Any], of: str) -> None:
    problem = ShellProblem(
        {**spec, "bound_angles_deg": [0, 45, -45] if of == "frequency" else [0, 45, 90]}
    )
    modes = QUANTITIES[of](stressed(problem), "").modes
    found = bound(stressed(problem), of, lambda _line: None)["of_angles"]
    values = []
    for a in itertools.product(found["allowed_deg"], repeat=3):
        angles = [*a, *(a[::-1] if of == "frequency" else ())]
        values.append(float(modes(turned(problem, dict(enumerate(angles))).K)[0][0]))
    best = (2.0 * np.pi * found["best"]) ** 2 if of == "frequency" else 1.0 / found["best"]
    assert best == pytest.approx(max(values), rel=1e-9)
    assert found["lay_ups"] == len(values)
    assert found["branches"] < len(values)
    assert found["gap"] < 1e-4


def test_no_lay_up_of_a_thick_plate_is_computed_twice() -> None:
    """Bounds without shear leave all of them open."""
    spec = square(4, [0.0, 90.0])
    for ply in spec["laminates"]["wall"]["plies"]:
        ply["thickness"] = 0.1
    loads = {"q": {"p": {"at": "plate", "force_per_area": [0.0, 0.0, 1.0]}}}
    best = bounded({**spec, "loads": loads, "bound_angles_deg": [0, 45, 90]}, "compliance")
    assert best["of_angles"]["computed"] == best["of_angles"]["lay_ups"] == 9


LOADS = {name: {"p": {"at": "plate", "force_per_area": [0.0, 0.0, 1.0]}} for name in ("q", "r")}
PULL = {"x": {"p": {"at": "right", "force_per_length": [-1.0, 0.0, 0.0]}}}
REFUSED = [
    ({"bound": "compliance", "loads": LOADS}, "expected one load case, found q, r"),
    ({"bound": "buckling", "loads": PULL}, "stresses of load case x depend on the lay-up"),
    ({"bound": "frequency", "elements": {"plate": "mitc3"}}, "expected elements.plate"),
    ({"bound": "frequency", "laminates": {"wall": {"plies": [
        {"material": "tin", "angle_deg": 0.0, "thickness": H}]}}}, "no ply has a direction"),
    ({"bound": "frequency", "loads": PULL, "frequencies": {"prestress": "x"}}, "prestress"),
]  # fmt: skip


@pytest.mark.parametrize(("changed", "words"), REFUSED)
def test_what_has_no_bound_is_refused_by_name(changed: dict[str, Any], words: str) -> None:
    spec = square(4, [0.0, 90.0])
    spec["materials"]["tin"] = {"kind": "isotropic", "E": 50e9, "nu": 0.3, "rho": 7300.0}
    if words.startswith("stresses"):  # held on both sides
        spec["supports"] = {**HARD, "right": {"at": "right", "fixed": ["uy", "uz", "rx"]}}
    with pytest.raises(ShellError, match=words):
        analyse({**spec, **changed})
