"""The elements against another formulation on the same triangles: quadratic displacement, CR
rotations (preprocess/shell/analyses/second_route.py). Both meet the references; both meet each
other."""

from typing import Any

import numpy as np
import pytest
from samples.shell_benchmarks import expected, numbers, tolerances
from samples.shell_cantilevers import box
from samples.shell_model import Model
from samples.shell_obstacle_course import scordelis, twisted_beam
from samples.shell_specs import HARD, plate
from samples.shell_squares import cross_ply

from plymotion.preprocess.shell.analyses.second_route import SecondRoute
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.analyses.shell_verification import fixed, right_side
from plymotion.preprocess.shell.model import freedom
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.model.stiffeners import Stiffener
from plymotion.solver.math.arrays import Array

# The numbers of the elements are those of both DOLFINx: test_shell_benchmarks.py.
ONE_END = pytest.mark.one_end
CELLS = [{}, pytest.param({"element": "quadrilateral"}, marks=ONE_END)]


class Second:
    """The second formulation of a problem, with its supports and loads."""

    def __init__(self, model: Model) -> None:
        self.problem = ShellProblem(model.spec(), "second")
        self.route = SecondRoute(self.problem)
        self.held = fixed(self.route, self.problem, "loads")

    def solved(self, case: dict[str, Any]) -> tuple[Array, Array]:
        """Right-hand side and displacements of a load case."""
        rhs, given = right_side(self.route, self.problem, case)
        return rhs, self.route.solve(rhs, self.held, given)

    def at(self, component: int, place: tuple[float, float, float]) -> int:
        """Unknown of a component of the displacement of the node at a place."""
        gap = np.linalg.norm(self.problem.mesh.points_G - place, axis=1)
        assert gap.min() < 1e-6 * self.problem.mesh.size
        return int(self.route.u[np.argmin(gap), component])


@ONE_END
def test_scordelis_lo() -> None:
    model, _ = scordelis(16)
    shell = Second(model)
    _, u = shell.solved(model.loads["weight"])
    angle = np.radians(40.0)
    found = -u[shell.at(2, (0.0, 25.0 * np.sin(angle), 25.0 * np.cos(angle)))]
    assert found == pytest.approx(expected("scordelis")[0], rel=tolerances("scordelis")[0])
    assert numbers("scordelis", 16)[0] == pytest.approx(found, rel=5e-3)


@ONE_END
@pytest.mark.parametrize("direction", ["y", "z"])
def test_twisted_beam(direction: str) -> None:
    name = f"twisted_{direction}"
    model, _ = twisted_beam((24, 4), direction)
    (case,) = model.loads.values()
    rhs, u = Second(model).solved(case)
    found = rhs @ u
    assert found == pytest.approx(expected(name)[0], rel=tolerances(name)[0])
    assert numbers(name, (24, 4))[0] == pytest.approx(found, rel=1e-2)


@ONE_END
def test_unsymmetric_laminate() -> None:
    """[0/90], a/h = 10: the coupling B, with its sign, in both."""
    model, _ = cross_ply(12, "sin", "0_90", "10")
    shell = Second(model)
    _, w = shell.solved(model.loads["q"])
    found = 0.1 * w[shell.at(2, (0.5, 0.5, 0.0))]  # 100 h^3
    name = "fsdt_sin_0_90_ah10"
    assert found == pytest.approx(expected(name)[0], rel=tolerances(name)[0])
    # u at the middle of an edge is B's work alone: it changes sign with the order of the plies
    ux = w[shell.at(0, (0.0, 0.5, 0.0))]
    ours = model.solved(mesh={"n_length": 32, "n_width": 32})
    row = int(np.argmin(np.linalg.norm(ours.points_G - [0.0, 0.5, 0.0], axis=1)))
    assert ours.statics.displacements[6 * row, 0] == pytest.approx(ux, rel=1e-2)
    assert abs(ux) > 0.01 * abs(w).max()


@ONE_END
def test_composite_box_of_coupled_walls() -> None:
    """CAS 15: on 1120 triangles the second formulation meets CalculiX's S8R within 1 %."""
    model, _ = box((40, 4, 3), "cas15")
    shell = Second(model)
    found = [*np.sqrt(shell.route.eigenvalues(6, shell.held)) / (2.0 * np.pi)]
    for force in ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]):
        rhs, u = shell.solved({"F": {"at": "tip", "force": force}})
        found.append(rhs @ u)
    assert found == pytest.approx(expected("ccx_box_cas15")[:8], rel=1e-2)


LOADS = {
    "press": {"all": {"pressure": 1.0, "sine": [1.0, 1.0, 0.0]}},
    "pull": {"tip": {"at": "right", "force": [1.0, 0.5, 0.2]}},
    "turn": {"tip": {"at": "right", "moment": [0.0, 0.1, 0.0]}},
    "spread": {"all": {"at": "plate", "force": [0.0, 1.0, 0.3], "moment": [0.1, 0.2, 0.05]}},
    "edge": {"top": {"at": "top", "force_per_length": [0.0, 0.0, 1.0]}},
    "corner": {"tip": {"at": "corner-11", "force": [0.0, 0.0, 0.1]}},
    "fall": {"all": {"gravity": [1.0, 0.0, 9.81]}},
    "push": {"end": {"at": "left", "motion": {"ry": 1e-3}}},
}
CLAMPED = {"left": {"at": "left", "fixed": "all"}}


def analysed(spec: dict[str, Any]) -> tuple[str, list[str]]:
    found = analyse(spec, verify=True)
    return str(found.provenance["verification"]), [w["code"] for w in found.warnings]


@pytest.mark.one_end
@pytest.mark.parametrize("cells", CELLS)
def test_two_routes_agree(cells: dict[str, str]) -> None:
    supports = CLAMPED | {"right": {"at": "right", "fixed": ["uz"], "only": "loads"}}
    spec = plate(12, 0.02, supports=supports, loads=LOADS, frequencies={"count": 4})
    spec["mesh"] |= cells
    spec["regions"]["all"] |= {"flip": True}
    words, codes = analysed(spec)
    assert "of which meshes explain" in words
    assert "too coarse" not in words
    assert "verification-differs" not in codes
    free = {"count": 3, "free": True, "error": False}
    assert analysed(plate(8, 0.01, frequencies=free))[0].startswith("frequency")


@ONE_END
@pytest.mark.provokes("verification-differs")
@pytest.mark.parametrize("matrix", ["K", "M"])
def test_a_wrong_matrix_is_found(matrix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    spec = plate(10, 0.01, supports=HARD, frequencies={"count": 2})
    assert "verification-differs" not in analysed(spec)[1]
    made = getattr(ShellProblem, matrix).func
    monkeypatch.setattr(ShellProblem, matrix, property(lambda self: 1.1 * made(self)))
    words, codes = analysed(spec)
    assert "verification-differs" in codes, words


@ONE_END
def test_a_wrong_load_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = plate(12, 0.02, supports=CLAMPED, loads={"fall": LOADS["fall"]})
    made = ShellProblem.loads.func
    assert "verification-differs" not in analysed(spec)[1]

    def heavier(self: ShellProblem) -> Any:
        found = made(self)
        gravity = found._gravity
        found._gravity = lambda acceleration: 1.05 * gravity(acceleration)
        return found

    monkeypatch.setattr(ShellProblem, "loads", property(heavier))
    assert "verification-differs" in analysed(spec)[1]


@ONE_END
def test_the_second_method_is_too_stiff_for_a_large_offset() -> None:
    spec = plate(2, 1e-3, supports=CLAMPED, frequencies={"count": 2})
    spec["mesh"]["element"] = "quadrilateral"
    spec["laminates"] = {
        "far": {"plies": [{"material": "metal", "thickness": 1e-3}], "offset": 0.01}
    }
    spec["regions"] = {"all": {"laminate": "far"}}
    words, codes = analysed(spec)
    assert words.endswith("the second method is too stiff for offsets of a wall")
    assert "verification-differs" not in codes


RIB = {
    "stiffness": np.diag([4e7, 1e7, 1e7, 4e4, 8e4, 5e4]).tolist(),
    "mass": np.diag([3.0, 3.0, 3.0, 2e-3, 1e-3, 1e-3]).tolist(),
}


def linked(kind: str, cells: dict[str, str] | None = None) -> dict[str, Any]:
    """A plate with a rib and a point off its edge that a link moves or follows."""
    loads: dict[str, Any] = {
        "push": {"tip": {"at": "end", "force": [1.0, 2.0, 3.0]}},
        "turn": {"tip": {"at": "end", "moment": [0.3, 0.2, 0.1]}},
        "rib": {"tip": {"at": "corner-11", "moment": [0.0, 1.0, 0.0]}},
        "fall": {"all": {"gravity": [0.0, 1.0, 9.81]}},
    }
    spec = plate(
        (8, 8), 0.02, supports=CLAMPED, loads=loads, frequencies={"count": 3},
        links={"end": {"at": "right", "kind": kind, "point": [1.2, 0.6, 0.1]}},
        stiffeners={"rib": {"at": "top", "offset": [0.01, 0.03], **RIB}},
    )  # fmt: skip
    spec["mesh"] |= cells or {}
    return spec


@pytest.mark.one_end
@pytest.mark.parametrize("kind", ["rigid", "average"])
@pytest.mark.parametrize("cells", CELLS)
def test_links_and_stiffeners_agree(kind: str, cells: dict[str, str]) -> None:
    words, codes = analysed(linked(kind, cells))
    assert words.startswith(("frequency", "strain energy")), words
    assert float(words.split("difference ")[1].split(" %")[0]) < 2.0
    assert "too coarse" not in words
    assert codes == []


@ONE_END
@pytest.mark.provokes("verification-differs")
@pytest.mark.parametrize("wrong", ["link", "stiffness", "mass"])
def test_a_wrong_link_or_stiffener_is_found(wrong: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if wrong == "link":
        made = freedom.averaged
        monkeypatch.setattr(freedom, "averaged", lambda arms, w: made(0.9 * arms, w))
    else:
        of = getattr(Stiffener, wrong)
        monkeypatch.setattr(Stiffener, wrong, lambda self, *form: 2.0 * of(self, *form))
    words, codes = analysed(linked("average"))
    assert "verification-differs" in codes, words


def test_a_moment_at_a_point_is_not_judged() -> None:
    """Its strain energy grows with every refinement."""
    loads = {"point": {"tip": {"at": "corner-11", "moment": [1.0, 1.0, 0.0]}}}
    words, codes = analysed(plate(8, 0.02, supports=CLAMPED, loads=loads))
    assert words == (
        "not done: a moment at a point has no limit for finer cells in strain energy of point"
    )
    assert codes == []


@pytest.mark.one_end
@pytest.mark.parametrize("at", ["corner-11", ["corner-10", "corner-11"]])
def test_rigid_links_of_points(at: str | list[str]) -> None:
    links = {"end": {"at": at, "kind": "rigid"}}
    loads = {"pull": {"tip": {"at": "end", "force": [0.0, 0.0, 1.0]}}}
    words, codes = analysed(plate(8, 0.02, supports=CLAMPED, links=links, loads=loads))
    assert words.startswith("strain energy of pull: difference")
    assert "verification-differs" not in codes, words


@pytest.mark.one_end
def test_what_is_not_compared_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    held = {"point": {"at": "corner-00", "fixed": "all"}}
    assert analysed(plate(4, 0.01, supports=held, frequencies={}))[0] == (
        "not done for a rotation held at a point"
    )
    assert analysed(plate(4, 0.01, supports=HARD))[0] == (
        "not done for a shell without load cases and unstressed modes"
    )
    with monkeypatch.context() as smaller:
        smaller.setattr("plymotion.preprocess.shell.analyses.shell_verification.MOST", 1000)
        assert analysed(plate(4, 0.01, supports=HARD, frequencies={}))[0] == (
            "not done for about 1701 unknowns of the second method on a mesh of half the cell "
            "size, expected at most 1000: verify the same shell with larger cells"
        )
    few = analysed(plate(2, 0.01, supports=HARD, frequencies={"count": 6}))[0]
    assert "the mesh is too coarse for frequency" in few
