"""Loads of shells: resultants to the last digits, work-consistent shares, messages."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from samples.shell_specs import CFRP, METAL, SCRIPTS, box, mesh_from, plate

from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.groups import cell_directions, group
from plymotion.preprocess.shell.model.loads import resultant
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.shell_cells import ShellError

Record = Callable[[str, Any], None]
ORIGIN = np.zeros(3)


def total(problem: ShellProblem, **load: Any) -> Any:
    """Force and moment about the origin of one load."""
    forces = problem.loads.case({"load": load}, "loads.case")
    return resultant(problem.mesh, problem.freedom, forces[:, None], ORIGIN)[:, 0]


@pytest.fixture(scope="module")
def distorted() -> ShellProblem:
    spec = plate((7, 5), 0.01, 2.0, 1.0)
    spec["mesh"]["parameters"]["distortion"] = 0.2
    return ShellProblem(spec)


def test_shares_of_groups(distorted: ShellProblem) -> None:
    mesh = distorted.mesh
    assert group(mesh, "left", "at").weights.sum() == pytest.approx(1.0, rel=1e-14)
    assert group(mesh, "top", "at").centre_G == pytest.approx([1.0, 1.0, 0.0])
    assert group(mesh, "plate", "at").weights.sum() == pytest.approx(2.0, rel=1e-14)
    assert group(mesh, "plate", "at").centre_G == pytest.approx([1.0, 0.5, 0.0])
    assert len(group(mesh, "corner-11", "at").nodes) == 1


def test_link_to_several_surfaces() -> None:
    """Shares of both skins of a box; the edges in common count for both."""
    links = {"skins": {"at": ["top", "bottom"], "kind": "average"}}
    problem = ShellProblem(box(links=links))
    of, parts = problem.links[0].group, [group(problem.mesh, n, "at") for n in ("top", "bottom")]
    assert of.weights.sum() == pytest.approx(sum(part.weights.sum() for part in parts))
    assert set(of.nodes) == {int(n) for part in parts for n in part.nodes}
    assert of.centre_G == pytest.approx(0.5 * (parts[0].centre_G + parts[1].centre_G))
    for at, words in (
        (["top", "root"], "of curves or of surfaces"),
        (["top", "tp"], "no physical"),
    ):
        links["skins"]["at"] = at
        with pytest.raises(ShellError, match=rf"links.skins.at.*{words}"):
            ShellProblem(box(links=links))


@pytest.mark.parametrize(
    ("load", "force", "moment"),
    [
        ({"at": "right", "force": [3.0, 4.0, 5.0]}, [3, 4, 5], [2.5, -10, 6.5]),
        ({"at": "right", "force_per_length": [3.0, 4.0, 5.0]}, [3, 4, 5], [2.5, -10, 6.5]),
        ({"at": "right", "moment": [3.0, 4.0, 5.0]}, [0, 0, 0], [3, 4, 5]),
        ({"at": "corner-11", "force": [0.0, 0.0, 2.0]}, [0, 0, 2], [2, -4, 0]),
        ({"at": "plate", "force": [0.0, 0.0, 2.0]}, [0, 0, 2], [1, -2, 0]),
        ({"force_per_area": [1.0, 0.0, 2.0]}, [2, 0, 4], [2, -4, -1]),
        ({"pressure": 3.0}, [0, 0, 6], [3, -6, 0]),
        ({"at": "plate", "pressure": 3.0}, [0, 0, 6], [3, -6, 0]),
        ({"gravity": [0.0, -2.0, 0.0]}, [0, -108, 0], [0, 0, -108]),
    ],
)
def test_resultants(
    distorted: ShellProblem, load: dict[str, Any], force: list[float], moment: list[float]
) -> None:
    """The plate is 2 x 1 m, 0.01 m thick: 54 kg, its centre at (1, 0.5)."""
    assert total(distorted, **load) == pytest.approx([*force, *moment], abs=1e-10)


def test_sine_load(record: Record) -> None:
    """Linear displacements, three points: its sum to second order in the cells' size."""
    sums = [
        total(ShellProblem(plate(n, 0.01)), pressure=1.0, sine=[1.0, 1.0, 0.0])[2] for n in (8, 16)
    ]
    exact = 4.0 / np.pi**2
    assert abs(sums[0] - exact) < 2e-4
    assert abs(sums[1] - exact) < 0.1 * abs(sums[0] - exact)  # degree 2: fourth order
    record("shell sine load", sums)


def test_pressure_follows_the_normal() -> None:
    """On a closed tube it has no resultant; flipped regions push the other way."""
    closed = total(ShellProblem(box()), pressure=2.0)
    assert closed == pytest.approx(np.zeros(6), abs=1e-12)
    problem = ShellProblem(box())
    up = total(problem, at="top", pressure=2.0)
    width = 0.0242 - 0.000762
    assert up[:3] == pytest.approx([0.0, 0.0, 2.0 * width], abs=1e-12)
    spec = box()
    spec["regions"]["top"]["flip"] = True
    assert total(ShellProblem(spec), at="top", pressure=2.0) == pytest.approx(-up, abs=1e-12)


@pytest.mark.one_end
@pytest.mark.parametrize("membrane", ["opt", "allman", "cst"])
def test_pull_on_an_edge_is_uniform_stress(membrane: str) -> None:
    """An unsymmetric mesh; the bowed sides of opt and allman need moments at the nodes."""
    spec = plate(
        (4, 3),
        0.01,
        supports={
            "left": {"at": "left", "fixed": ["ux", "rz"]},  # no bow on this side either
            "bottom": {"at": "corner-00", "fixed": ["uy", "uz", "rx", "ry"]},
            "corner": {"at": "corner-01", "fixed": ["uz"]},
        },
        loads={"pull": {"edge": {"at": "right", "force": [1e6, 0.0, 0.0]}}},
        elements={"membrane": membrane},
    )
    spec["mesh"]["parameters"] |= {"distortion": 0.2, "diagonals": 0}
    found = analyse(spec)
    expected = np.array([1e6, 0, 0, 0, 0, 0, 0, 0])
    assert np.abs(found.cases.resultants_E[0] - expected).max() < 1e-2
    stretch = 1e6 / (METAL["E"] * 0.01)
    u = found.cases.displacements_G[0]
    assert u[:, 0] == pytest.approx(stretch * found.mesh.nodes_G[:, 0], abs=1e-8 * stretch)


def test_gravity_is_the_mass_of_the_offset_laminate() -> None:
    """A ply beside the mesh hangs with a moment on it."""
    spec = plate(4, 0.01)
    spec["regions"]["all"] |= {"offset": "bottom"}
    problem = ShellProblem(spec)
    weight = 2700.0 * 0.01
    found = total(problem, gravity=[1.0, 0.0, 0.0])
    assert found[:3] == pytest.approx([weight, 0.0, 0.0])
    assert found[4] == pytest.approx(0.005 * weight)


@pytest.mark.parametrize(
    ("load", "message"),
    [
        ({"at": "right"}, "no load; expected one of force"),
        ({"at": "rihgt", "force": [1, 0, 0]}, "no physical group.*did you mean 'right'"),
        ({"force": [1, 0, 0]}, "at: missing"),
        ({"at": "right", "force": [1, 0]}, "expected three numbers"),
        ({"at": "plate", "force_per_length": [1, 0, 0]}, "needs a physical curve"),
        ({"at": "right", "pressure": 1.0}, "needs a physical surface"),
        ({"at": "right", "gravity": [0, 0, 1]}, "whole shell"),
        ({"at": "right", "force": [1, 0, 0], "sine": [1, 1, 0]}, "together with"),
        ({"pressure": "much"}, "expected a number"),
    ],
)
def test_wrong_loads(distorted: ShellProblem, load: dict[str, Any], message: str) -> None:
    with pytest.raises(ShellError, match=message):
        distorted.loads.case({"x": load}, "loads.case")


def test_unknown_keys_are_named() -> None:
    with pytest.raises(ShellError, match=r"preassure: unknown key.*did you mean 'pressure'"):
        ShellProblem(plate(2, 0.1, loads={"a": {"b": {"preassure": 1.0}}}))
    with pytest.raises(ShellError, match=r"support: unknown key.*did you mean 'supports'"):
        ShellProblem(plate(2, 0.1, support={}))
    with pytest.raises(ShellError, match=r"fixed.*'ua' is not one of ux"):
        ShellProblem(plate(2, 0.1, supports={"a": {"at": "left", "fixed": ["ua"]}}))
    with pytest.raises(ShellError, match=r"kind = 'ridgid'.*did you mean 'rigid'"):
        ShellProblem(plate(2, 0.1, links={"a": {"at": "left", "kind": "ridgid"}}))
    with pytest.raises(ShellError, match="what = 'w'"):
        analyse(plate(2, 0.1, probes={"a": {"at": "left", "what": "w"}}))
    with pytest.raises(ShellError, match=r"plate.*expected one of dkmt.*did you mean 'dkmt'"):
        ShellProblem(plate(2, 0.1, elements={"plate": "dkm"}))


def test_reference_directions() -> None:
    about = {"axis_about": {"point": [0.0, 0.0, 0.0], "direction": [2.0, 0.0, 0.0]}}
    spec = {
        **plate(2, 0.01),
        "mesh": {"file": str(SCRIPTS / "cylinder.py"), "parameters": {}},
        "materials": {"cfrp": CFRP},
        "regions": {"all": {"material": "cfrp", "thickness": 0.01, **about}},
    }
    problem = ShellProblem(spec)
    e1 = problem.regions[0].geometry.A_GE[:, :, 0]
    middle = problem.mesh.points_G[problem.mesh.cells].mean(axis=1)
    around = np.cross([1.0, 0.0, 0.0], middle)
    around /= np.linalg.norm(around, axis=1)[:, None]
    assert np.einsum("ci,ci->c", e1, around).min() > 0.999
    # the nearest edge of a curve: left of the middle along y, right of it along x + y
    mesh = mesh_from(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0], [2, 2, 0]],
        [[0, 1, 2], [1, 3, 2], [1, 4, 3], [3, 4, 5]],
        bent=[[0, 2], [3, 5]],
    )
    cells = np.arange(len(mesh.cells))
    found = cell_directions(mesh, {"axis_curve": "bent"}, cells, "region")
    along = np.abs(found[[0, 3]])
    assert along == pytest.approx(np.array([[0, 1, 0], [0.5**0.5, 0.5**0.5, 0]]))
    with pytest.raises(ShellError, match="no physical curve"):
        cell_directions(mesh, {"axis_curve": "bend"}, cells, "region")
    with pytest.raises(ShellError, match="longer than 0"):
        cell_directions(mesh, {"axis": [0, 0, 0]}, cells, "region")
    with pytest.raises(ShellError, match="expected one of axis"):
        cell_directions(mesh, {"axis": [1, 0, 0], "axis_curve": "bent"}, cells, "region")
