"""Bounds over all lay-ups against closed forms of simply supported plates and random lay-ups.

Without transverse shear, a rectangular plate a x b with simply supported edges and D16 = D26 = 0
has the shapes sin(m pi x/a) sin(n pi y/b). As lambda is concave and does not change with the sign
of all angles, its maximum over mixtures is one of D16 = D26 = 0.
"""

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from samples.shell_model import SCRIPTS
from samples.shell_specs import HARD, plate
from samples.thin_plates import (
    BEST,
    D0,
    PLY,
    POUND_PER_INCH,
    STEPS,
    bending,
    constants,
    load_factors,
)
from scipy.optimize import linprog

from plymotion.preprocess.shell.analyses.bound import QUANTITIES, bound, turned
from plymotion.preprocess.shell.analyses.buckling import Stressed
from plymotion.preprocess.shell.analyses.cases import load_cases
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.shell_cells import ShellError
from plymotion.solver.package.shell.plies import harmonics

pytestmark = pytest.mark.one_end
H = 1e-3
OMEGA = 2.0 * np.pi * np.sqrt(1500.0 / D0) / H  # of Narita, per Hz
QUADS = {"element": "quadrilateral"}


def laminated(
    spec: dict[str, Any], material: str, angles: Any, h: float, *, mirrored: bool = True
) -> dict[str, Any]:
    """A shell of one laminate of equal plies."""
    angles = [*angles, *(angles[::-1] if mirrored else ())]
    plies = [
        {"material": "ply", "angle_deg": float(a), "thickness": h / len(angles)} for a in angles
    ]
    return {
        **spec,
        "materials": {"ply": {"kind": "orthotropic", **constants(material)}},
        "laminates": {"wall": {"plies": plies}},
        "regions": {"all": {"laminate": "wall", "axis": [1.0, 0.1, 0.0]}},
    }


def square(n: int, angles: Any, **tables: Any) -> dict[str, Any]:
    """A thin square with simply supported edges."""
    spec = laminated(plate(n, H, supports=HARD, **tables), "narita", angles, H)
    spec["regions"]["all"]["axis"] = [1.0, 0.0, 0.0]
    return spec


def test_the_square_of_narita() -> None:
    """The limit of finer meshes is the closed form at xi = (0, -1); the search finds his lay-up."""
    D = bending("narita", 1.0, np.array([0.0, 0.0, -1.0, 0.0])) / D0
    exact = np.pi**2 * np.sqrt(D[0, 0] + 2.0 * D[0, 1] + 4.0 * D[2, 2] + D[1, 1])
    spec = {"bound": "frequency", "bound_angles_deg": STEPS}
    found = [analyse({**square(n, [0, 90, 0, 90]), **spec}) for n in (8, 16)]
    coarse, fine = (each.provenance["bound"] for each in found)
    errors = [OMEGA * each["bound"] / exact - 1.0 for each in (coarse, fine)]
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
    limit = (4.0 * fine["found"] - coarse["found"]) / 3.0
    published = BEST["frequency"]["supported"]["value"]
    assert OMEGA * limit == pytest.approx(published, rel=1e-3)


def test_the_best_angle_of_a_rectangle() -> None:
    """1.2 : 1, simply supported: [theta, -theta] of many plies has a closed form."""
    a, theta = 1.2, np.linspace(0.0, 90.0, 901)
    xi = harmonics(theta) * [1.0, 0.0, 1.0, 0.0]
    D = np.array([bending("narita", 1.0, each) for each in xi]) / D0
    work = D[:, 0, 0] / a**4 + 2.0 * (D[:, 0, 1] + 2.0 * D[:, 2, 2]) / a**2 + D[:, 1, 1]
    spec = laminated(plate((12, 10), H, a, supports=HARD), "narita", [0.0] * 8, H)
    spec["regions"]["all"]["axis"] = [1.0, 0.0, 0.0]
    found = bounded(spec | {"elements": {"plate": "dkt"}}, "frequency")
    assert OMEGA * found["bound"] == pytest.approx(
        np.pi**2 * np.sqrt(work.max()), rel=1.5e-2
    )  # the mesh
    assert np.abs(found["found_angles_deg"]) == pytest.approx(theta[work.argmax()], abs=1.0)
    assert found["found_gap"] < 1e-2


def test_the_clamped_square_of_narita() -> None:
    """No lay-up of his angles or of any is better, but for what the bound says."""
    table = BEST["frequency"]["clamped"]
    spec = square(8, table["plies"], bound_angles_deg=STEPS)
    spec["supports"] = {name: {"at": name, "fixed": "all"} for name in HARD}
    found = bounded(spec, "frequency")
    assert OMEGA * found["value"] == pytest.approx(table["value"], rel=0.03)  # 8 x 8 cells
    assert found["of_angles"]["best"] == pytest.approx(found["value"], rel=1e-5)
    assert found["of_angles"]["gap"] < 1e-4
    assert found["found_gap"] < 1e-2


def best_mixture(factors: Callable[[Any], Any], angles_deg: Any) -> float:
    """Largest least of some functions of lamination parameters, without those of sin 2a, sin 4a."""
    xi = harmonics(np.array(angles_deg)) * [1.0, 0.0, 1.0, 0.0]
    values = np.array([factors(each).ravel() for each in xi])
    optimum = linprog(
        np.append(0.0 * values[:, 0], -1.0),
        A_ub=np.c_[-values.T, np.ones(len(values.T))],
        b_ub=0.0 * values[0],
        A_eq=[[1.0] * len(xi) + [0.0]],
        b_eq=[1.0],
    )
    return float(-optimum.fun)


def pushed(plies: Any, h: float, size: tuple[float, float], cells: Any, ratio: float) -> Any:
    """A simply supported plate under Nx = 1 lb/in and Ny = ratio Nx."""
    edges = {name: {**edge, "fixed": ["uz", edge["fixed"][3]], "only": "modes"}
             for name, edge in HARD.items()}  # fmt: skip
    supports = {
        **edges,
        "flat": {"at": "plate", "fixed": ["uz", "rx", "ry"], "only": "loads"},
        "middle": {"at": "centre", "fixed": ["ux", "uy"]},
        "level": {"at": "right-middle", "fixed": ["uy"]},
    }
    N = POUND_PER_INCH
    push = {
        "right": [-N, 0, 0],
        "left": [N, 0, 0],
        "top": [0, -ratio * N, 0],
        "bottom": [0, ratio * N, 0],
    }
    loads = {"N": {k: {"at": k, "force_per_length": f} for k, f in push.items()}}
    spec = laminated(plate(cells, h, *size, supports=supports, loads=loads), "riche", plies, h)
    spec["regions"]["all"]["axis"] = [1.0, 0.0, 0.0]
    return spec | {"elements": {"plate": "dkt"}, "buckling": {"count": 1, "in_plane": False}}


def test_signs_of_angles_are_searched() -> None:
    """Two load factors meet at the best lay-up; turns of one ply end 0.24 % below the bound."""
    spec = pushed([0.0] * 8, H, (1.0, 0.6), (10, 6), 0.0)
    assert bounded(spec, "buckling")["found_gap"] < 1e-3


@pytest.mark.parametrize(("name", "cells"), [("48-plies", (24, 6)), ("64-plies", (20, 10))])
def test_the_panels_of_le_riche_and_haftka(name: str, cells: tuple[int, int]) -> None:
    """Without shear, as their formula of the load factor."""
    table = BEST["buckling"][name]
    plies, a, b, ratio = (table[key] for key in ("plies", "length", "width", "ratio"))
    h = 2.0 * PLY * len(plies)
    spec = pushed(plies, h, (a, b), cells, ratio)
    found = bounded({**spec, "bound_angles_deg": STEPS}, "buckling")
    best, own = found["of_angles"], [found["bound"], found["of_angles"]["best"], found["value"]]

    def factors(xi: Any) -> Any:
        return load_factors(bending("riche", h, xi), a, b, ratio)

    expected = [best_mixture(factors, each) for each in (np.linspace(0.0, 90.0, 181), STEPS)]
    assert own == pytest.approx([*expected, table["value"]], rel=3e-3)  # mesh, D16 and D26
    assert best["best"] > found["value"] * (1.0 - 1e-4)
    assert best["gap"] < 1e-4
    assert best["lay_ups"] == 4 ** len(plies)
    assert best["branches"] <= 200
    assert found["found_gap"] < 2e-3
    if name == "64-plies":  # nothing is better than the published one
        assert expected[1] == pytest.approx(table["value"], rel=1e-4)


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
    spec = laminated(spec, "narita", [45.0, -45.0, 0.0, 80.0], 0.01, mirrored=False)
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


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize(("changed", "words"), REFUSED)
def test_what_has_no_bound_is_refused_by_name(changed: dict[str, Any], words: str) -> None:
    spec = square(4, [0.0, 90.0])
    spec["materials"]["tin"] = {"kind": "isotropic", "E": 50e9, "nu": 0.3, "rho": 7300.0}
    if words.startswith("stresses"):  # held on both sides
        spec["supports"] = {**HARD, "right": {"at": "right", "fixed": ["uy", "uz", "rx"]}}
    with pytest.raises(ShellError, match=words):
        analyse({**spec, **changed})
