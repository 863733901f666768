"""Linear buckling of plates and shells, and their frequencies under load.

Published values of plates count the work on w only (in_plane = false): Timoshenko and Gere for
isotropic plates; Navier series of first-order theory (k = 5/6) for laminates, as in Reddy,
Mechanics of Laminated Composite Plates and Shells.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from samples.shell_cantilevers import cantilever
from samples.shell_model import SCRIPTS, isotropic, laminate
from samples.shell_specs import plate
from samples.shell_squares import lamina

from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.shell_cells import ShellError
from plymotion.solver.report.shell.findings import case_findings

Record = Callable[[str, Any], None]
QUADS = {"element": "quadrilateral"}
KINDS = [{}, QUADS]
NAMES = ["triangles", "quadrilaterals"]
SIMPLE = {"left": ["uz", "rx"], "right": ["uz", "rx"], "bottom": ["uz", "ry"], "top": ["uz", "ry"]}
CLAMPED = {name: ["uz", "rx", "ry"] for name in SIMPLE}
PUSH = {
    "x": {"right": [-1.0, 0.0, 0.0], "left": [1.0, 0.0, 0.0]},
    "shear": {
        "right": [0.0, 1.0, 0.0],
        "left": [0.0, -1.0, 0.0],
        "top": [1.0, 0.0, 0.0],
        "bottom": [-1.0, 0.0, 0.0],
    },
}
PUSH["xy"] = {**PUSH["x"], "top": [0.0, -1.0, 0.0], "bottom": [0.0, 1.0, 0.0]}


def compressed(
    n: int,
    stack: dict[str, Any],
    materials: dict[str, Any],
    edges: dict[str, list[str]],
    load: str,
    cells: dict[str, str],
) -> dict[str, Any]:
    """A unit square under edge loads of 1 N/m; a flat prestress, then its supports."""
    supports: dict[str, Any] = {
        name: {"at": name, "fixed": fixed, "only": "modes"} for name, fixed in edges.items()
    }
    supports["flat"] = {"at": "plate", "fixed": ["uz", "rx", "ry"], "only": "loads"}
    supports["middle"] = {"at": "centre", "fixed": ["ux", "uy", "rz"]}
    loads = {k: {"at": k, "force_per_length": f} for k, f in PUSH[load].items()}
    spec = plate(n, 1.0, supports=supports, loads={"N": loads})
    spec["mesh"].update(cells)
    return {
        **spec,
        "materials": materials,
        "laminates": {"wall": stack},
        "regions": {"all": {"laminate": "wall", "axis": [1.0, 0.0, 0.0]}},
        "buckling": {"count": 2, "in_plane": False},
    }


def first_factor(spec: dict[str, Any]) -> float:
    """The smallest load factor."""
    found = analyse(spec).buckling
    assert found is not None
    return float(found.factors[0])


ISOTROPIC = [
    (SIMPLE, "x", 4.0, 0.005),
    (SIMPLE, "xy", 2.0, 0.005),
    (SIMPLE, "shear", 9.325, 0.04),
    (CLAMPED, "x", 10.074, 0.01),
    (CLAMPED, "shear", 14.64, 0.05),
]


@pytest.mark.parametrize("cells", KINDS, ids=NAMES)
@pytest.mark.parametrize(("edges", "load", "k", "bound"), ISOTROPIC)
def test_isotropic_squares(
    edges: Any, load: str, k: float, bound: float, cells: dict[str, str], record: Record
) -> None:
    """k = N b^2 / (pi^2 D)."""
    h = 1.0 / 300.0
    stack, materials = isotropic(1.0, 0.3, h)
    D = h**3 / (12.0 * (1.0 - 0.3**2))
    found = first_factor(compressed(16, stack, materials, edges, load, cells))
    assert found / (np.pi**2 * D) == pytest.approx(k, rel=bound)
    record(f"shell/buckling/{load}/{len(edges['left'])}/{len(cells)}", found)


LAMINATES = [
    ([0, 90, 90, 0], 3.0, 10, 5.3991),
    ([0, 90, 90, 0], 10.0, 10, 9.9653),
    ([0, 90, 90, 0], 20.0, 10, 15.3513),
    ([0, 90, 90, 0], 40.0, 10, 23.4529),
    ([0, 90], 40.0, 10, 11.3526),
    ([0, 90], 40.0, 100, 12.9390),
    ([45, -45], 40.0, 10, 17.5522),
    ([45, -45], 40.0, 100, 21.6576),
]


@pytest.mark.one_end
@pytest.mark.parametrize("cells", KINDS, ids=NAMES)
@pytest.mark.parametrize(("plies", "E1", "ratio", "N"), LAMINATES)
def test_laminated_squares(
    plies: list[float], E1: float, ratio: float, N: float, cells: dict[str, str]
) -> None:
    """N a^2 / (E2 h^3) of simply supported squares: SS-1 of cross plies, SS-2 of angle plies."""
    h = 1.0 / ratio
    along = {"left": "uy", "right": "uy", "bottom": "ux", "top": "ux"}
    across = {"left": "ux", "right": "ux", "bottom": "uy", "top": "uy"}
    held = across if plies[0] == 45 else along
    edges = {name: [*fixed, held[name]] for name, fixed in SIMPLE.items()}
    stack = laminate("ply", [float(a) for a in plies], h, "5/6")
    spec = compressed(16, stack, {"ply": lamina(E1, 0.6, 0.5)}, edges, "x", cells)
    # a prestress without curvature: the laminate is held flat
    assert first_factor(spec) / h**3 == pytest.approx(N, rel=0.015)


CALCULIX = {  # S8R of CalculiX 2.20, 24 x 8 elements, *BUCKLE: benchmarks/shell_buckling.py
    "[0,0,90]s": (8.31343, 74.816),
    "[15,15,0]s": (5.08964, 44.9584),
    "[45,45,0]s": (1.52696, 13.834),
    "[45]3[-45]3": (1.41681, 12.8892),
}


@pytest.mark.one_end
@pytest.mark.parametrize("layup", CALCULIX)
def test_cantilever_plates_against_calculix(layup: str) -> None:
    model, _ = cantilever((24, 8), layup)
    model.loads = {"N": {"tip": {"at": "right", "force": [-1.0, 0.0, 0.0]}}}
    model.frequencies = {}
    found = analyse({**model.spec(cells=QUADS), "buckling": {"count": 2}}).buckling
    assert found is not None
    assert found.factors / CALCULIX[layup] == pytest.approx(np.ones(2), rel=6e-3)
    assert found.factors[0] == pytest.approx(CALCULIX[layup][0], rel=1.5e-3)


def column(n: tuple[int, int], direction: str, cells: dict[str, str]) -> float:
    """Load factor of a cantilever strip under 1 N, over Euler's."""
    L, b, h = 1.0, 0.05, 0.02
    spec = plate(n, h, L, b)
    spec["mesh"].update(cells)
    still = {"wide": ["uz", "rx", "ry"], "thin": ["uy", "rz"]}[direction]
    spec["supports"] = {
        "root": {"at": "left", "fixed": "all"},
        "plane": {"at": "plate", "fixed": still},
    }
    spec["loads"] = {"N": {"tip": {"at": "right", "force": [-1.0, 0.0, 0.0]}}}
    spec["buckling"] = {"count": 1}
    EI = 70e9 * (b**3 * h if direction == "wide" else h**3 * b) / 12.0
    return first_factor(spec) / (np.pi**2 * EI / (4.0 * L**2))


@pytest.mark.one_end
@pytest.mark.parametrize("cells", KINDS, ids=NAMES)
def test_columns_in_and_out_of_their_plane(cells: dict[str, str]) -> None:
    assert column((40, 4), "thin", cells) == pytest.approx(1.0, rel=0.005)
    assert column((40, 4), "wide", cells) == pytest.approx(1.0, rel=0.01)


@pytest.mark.one_end
@pytest.mark.parametrize("cells", KINDS, ids=NAMES)
def test_axially_compressed_cylinder(cells: dict[str, str]) -> None:
    """Classical stress E h / (R sqrt(3 (1 - nu^2))), on one octant with planes of symmetry."""
    R, L, h, E, nu = 1.0, 0.8, 0.01, 70e9, 0.3
    stack, materials = isotropic(E, nu, h)
    size = {"radius": R, "length": L, "second_deg": 90.0, "n_length": 20, "n_around": 40}
    spec = {
        "mesh": {"file": str(SCRIPTS / "cylinder.py"), "parameters": size, **cells},
        "materials": materials,
        "laminates": {"wall": stack},
        "regions": {"all": {"laminate": "wall", "axis": [1.0, 0.0, 0.0]}},
        "supports": {
            "near": {"at": "near", "fixed": "symmetry-x"},
            "first": {"at": "first", "fixed": "symmetry-y"},
            "second": {"at": "second", "fixed": "symmetry-z"},
            "end": {"at": "far", "fixed": ["uy", "uz"], "only": "modes"},
        },
        "loads": {"N": {"end": {"at": "far", "force_per_length": [-1.0, 0.0, 0.0]}}},
        "buckling": {"count": 3},
    }
    classical = E * h / (R * np.sqrt(3.0 * (1.0 - nu**2)))
    assert first_factor(spec) / (classical * h) == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize("cells", KINDS, ids=NAMES)
def test_ring_under_a_pressure_that_follows(cells: dict[str, str]) -> None:
    """A long tube: p = 3 D/R^3 (Levy 1884); 4 D/R^3 if the pressure kept its direction."""
    R, h = 1.0, 0.02
    stack, materials = isotropic(70e9, 0.3, h)
    size = {"radius": R, "length": 0.2, "second_deg": 90.0, "n_length": 2, "n_around": 40}
    spec = {
        "mesh": {"file": str(SCRIPTS / "cylinder.py"), "parameters": size, **cells},
        "materials": materials,
        "laminates": {"wall": stack},
        "regions": {"all": {"laminate": "wall", "axis": [1.0, 0.0, 0.0]}},
        "supports": {
            "near": {"at": "near", "fixed": "symmetry-x"},
            "far": {"at": "far", "fixed": "symmetry-x"},
            "first": {"at": "first", "fixed": "symmetry-y"},
            "second": {"at": "second", "fixed": "symmetry-z"},
        },
        "loads": {"p": {"all": {"pressure": -1.0}}},
        "buckling": {"count": 1},
    }
    D = 70e9 * h**3 / (12.0 * 0.91)
    assert first_factor(spec) == pytest.approx(3.0 * D / R**3, rel=0.01)


def test_rigid_rotations_of_a_stressed_shell_have_the_exact_second_order_work() -> None:
    """x' Kg x of a rotation = -(work of the dead loads on its second-order displacement)."""
    spec = plate((4, 3), 0.1, supports={"root": {"at": "left", "fixed": "all"}})
    rng = np.random.default_rng(2)
    problem = ShellProblem(spec)
    u = rng.normal(size=problem.freedom.n_dof) * 1e-3
    Kg = problem.geometric_stiffness(u)
    R = problem.freedom.rigid_motions()
    assert np.abs(Kg @ R[:, :3]).max() < 1e-9 * np.abs(Kg).max()
    N = problem.resultants(u[:, None])[0, :, :3]
    area = np.linalg.norm(problem.mesh.area_vectors_G, axis=1)
    mean = area @ N  # about x: Nyy, about y: Nxx, about z: both
    work = np.diag(R[:, 3:].T @ Kg @ R[:, 3:])
    assert work == pytest.approx([mean[1], mean[0], mean[0] + mean[1]], rel=1e-9)


@pytest.mark.one_end
def test_factors_far_below_one_are_found() -> None:
    """A load ten times and a thousand times the critical one."""
    stack, materials = isotropic(1.0, 0.3, 0.01)
    spec = compressed(8, stack, materials, SIMPLE, "x", {})
    one = first_factor(spec)
    for large in (10.0, 1000.0):
        for entry in spec["loads"]["N"].values():
            entry["force_per_length"] = [large / one * x for x in entry["force_per_length"]]
        found = first_factor(spec)
        for entry in spec["loads"]["N"].values():
            entry["force_per_length"] = [x * one / large for x in entry["force_per_length"]]
        assert found == pytest.approx(one / (large / one), rel=1e-8)


@pytest.mark.one_end
def test_tension_does_not_buckle_and_its_reverse_does() -> None:
    stack, materials = isotropic(1.0, 0.3, 0.01)
    pushed = compressed(8, stack, materials, SIMPLE, "x", {})
    pulled = compressed(8, stack, materials, SIMPLE, "x", {})
    for entry in pulled["loads"]["N"].values():
        entry["force_per_length"] = [-x for x in entry["force_per_length"]]
    pulled["buckling"]["error"] = True  # of no factor
    found = analyse(pulled).buckling
    assert found is not None
    assert found.error is not None
    assert not len(found.factors)
    assert not len(found.error)
    assert found.reversed[0] == pytest.approx(-first_factor(pushed), rel=1e-8)


@pytest.mark.one_end
def test_constant_loads_and_frequencies_fall_together() -> None:
    """f^2 falls linearly to 0 at the critical load, and half of it leaves half as a factor."""
    stack, materials = isotropic(1.0, 0.3, 0.01)
    spec = compressed(8, stack, materials, SIMPLE, "x", {})
    critical = first_factor(spec)
    half = {
        name: {**entry, "force_per_length": [0.5 * critical * x for x in entry["force_per_length"]]}
        for name, entry in spec["loads"]["N"].items()
    }
    spec["loads"]["half"] = half
    spec["buckling"] |= {"constant": "half", "cases": ["N"]}
    spec["supports"]["in-plane"] = {"at": "plate", "fixed": ["ux", "uy", "rz"], "only": "modes"}
    assert first_factor(spec) == pytest.approx(0.5 * critical, rel=1e-6)
    spec["buckling"] = {"in_plane": True, "count": 1}
    spec["frequencies"] = {"count": 1}
    free = analyse(spec).modes
    spec["frequencies"] = {"count": 1, "prestress": "half"}
    loaded = analyse(spec).modes
    assert free is not None
    assert loaded is not None
    assert loaded.frequencies[0] ** 2 == pytest.approx(0.5 * free.frequencies[0] ** 2, rel=2e-3)
    # 1 N/m is far above the critical load
    with pytest.raises(ShellError, match=r"prestress = 'N': the shell has buckled"):
        analyse({**spec, "frequencies": {"count": 1, "prestress": "N"}})


@pytest.mark.provokes("buckling-after-large-rotation")
def test_bent_prestress_is_warned_about() -> None:
    spec = plate((10, 2), 0.01, 1.0, 0.2, supports={"root": {"at": "left", "fixed": "all"}})
    spec["loads"] = {"F": {"tip": {"at": "right", "force": [-1.0, 0.0, 1.0]}}}
    spec["buckling"] = {"count": 1}
    codes = [warning["code"] for warning in analyse(spec).warnings]
    assert codes == ["buckling-after-large-rotation"]
    spec["loads"]["F"]["tip"]["force"] = [-1.0, 0.0, 0.0]
    assert not analyse(spec).warnings


@pytest.mark.one_end
@pytest.mark.provokes("buckles-in-plane")
def test_a_thick_plate_that_turns_in_its_plane_is_warned_about() -> None:
    """Held in its plane at one node, a thick plate under dead loads turns there long before it
    buckles; held at two, it buckles as in tables."""
    stack = laminate("ply", [0, 90, 90, 0], 0.1, "5/6")
    spec = compressed(8, stack, {"ply": lamina(3.0, 0.6, 0.5)}, SIMPLE, "x", QUADS)
    spec["buckling"] = {"count": 1}
    turning = analyse(spec)
    assert [warning["code"] for warning in turning.warnings] == ["buckles-in-plane"]
    spec["supports"]["middle"]["fixed"] = ["ux", "uy"]
    spec["supports"]["level"] = {"at": "right-middle", "fixed": ["uy"]}
    held = analyse(spec)
    assert not held.warnings
    assert turning.buckling is not None
    assert held.buckling is not None
    assert turning.buckling.factors[0] < 0.1 * held.buckling.factors[0]
    assert case_findings(held)[0].imbalance < 1e-8  # of loads without a resultant


def test_wrong_requests() -> None:
    spec = plate(4, 0.01, supports={"root": {"at": "left", "fixed": "all"}})
    spec["loads"] = {"pull": {"tip": {"at": "right", "force": [-1.0, 0.0, 0.0]}}}
    with pytest.raises(ShellError, match=r"buckling.cases = 'pul': no load case.*pull"):
        analyse({**spec, "buckling": {"cases": ["pul"]}})
    with pytest.raises(ShellError, match=r"buckling.count = 0"):
        analyse({**spec, "buckling": {"count": 0}})
    with pytest.raises(ShellError, match=r"frequencies.prestress = 'push'"):
        analyse({**spec, "frequencies": {"prestress": "push"}})
    free = {"root": {**spec["supports"]["root"], "only": "loads"}}
    with pytest.raises(ShellError, match="rigid motions are free"):
        analyse({**spec, "supports": free, "buckling": {}})


def test_prescribed_displacements() -> None:
    """A strip pulled by a displacement has the reaction of the same strip pulled by that force."""
    held = {"root": {"at": "left", "fixed": "all"}, "tip": {"at": "right", "fixed": ["ux"]}}
    loads = {"pull": {"tip": {"at": "right", "motion": {"ux": 1e-3}}}}
    spec = plate((8, 2), 0.01, 1.0, 0.2, supports=held, loads=loads)
    found = analyse(spec).cases
    reaction = found.reactions_G[0, 1, 0]
    assert found.reactions_G[0].sum(axis=0)[0] == pytest.approx(0.0, abs=1e-6 * reaction)
    assert found.energy[0] == pytest.approx(0.5 * reaction * 1e-3, rel=1e-9)
    assert reaction == pytest.approx(70e9 * 0.002 * 1e-3, rel=0.02)
    linked = plate((8, 2), 0.01, 1.0, 0.2)
    linked["links"] = {"end": {"at": "right", "kind": "rigid"}}
    linked["supports"] = {"root": held["root"], "end": {"at": "end", "fixed": "all"}}
    linked["loads"] = {"turn": {"end": {"at": "end", "motion": {"ry": 0.01, "ux": 1e-3}}}}
    result = analyse(linked)
    assert result.cases.link_motions_G[0, 0] == pytest.approx([1e-3, 0, 0, 0, 0.01, 0], abs=1e-15)
    loads = {"pull": {"tip": {"at": "right", "motion": {"uz": 1e-3}}}}
    with pytest.raises(ShellError, match=r"motion.uz: no support holds uz of 'right'"):
        analyse({**spec, "loads": loads})
