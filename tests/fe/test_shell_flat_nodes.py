"""Five degrees of freedom where the shell is flat, six at kinks."""

from typing import Any

import numpy as np
import pytest
from samples.shell_specs import HARD, box, mesh_from, plate

from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.solver.math.rotations import vector_to_matrix

NONE, TIE = ({"membrane": "cst", "drilling": name} for name in ("none", "tie"))
PRESS = {"q": {"all": {"pressure": 1.0}}}
TURN = vector_to_matrix(np.array([0.4, -0.9, 0.7]))


def _askew(turn: Any, **tables: Any) -> Any:
    """A clamped-edge square, 6 x 6, in any plane: results of a pressure, and two modes."""
    spec = plate(6, 0.01, supports={"a": {"at": "left", "fixed": "all"}}, loads=PRESS, **tables)
    spec["frequencies"] = {"count": 3}
    n = 6
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3) @ turn.T
    k = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = k[:-1, :-1].ravel(), k[1:, :-1].ravel(), k[1:, 1:].ravel(), k[:-1, 1:].ravel()
    cells = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    left = np.stack([k[0, :-1], k[0, 1:]], axis=1)
    spec["regions"] = {"s1": {**spec["regions"]["all"], "axis": turn[:, 0].tolist()}}
    spec["loads"] = {"q": {"all": {"at": "s1", "pressure": 1.0}}}
    return analyse(spec, mesh=mesh_from(points, cells, left=left))


@pytest.mark.one_end
@pytest.mark.parametrize("turn", [np.eye(3), TURN], ids=["in a coordinate plane", "askew"])
def test_bending_does_not_see_the_drilling(turn: Any) -> None:
    """A flat plate: 5 unknowns a node give what 6 give."""
    five, six = (_askew(turn, elements=elements) for elements in (NONE, TIE))
    w5, w6 = (
        found.cases.displacements_G[0] @ np.kron(np.eye(2), turn[:, 2:]) for found in (five, six)
    )
    np.testing.assert_allclose(w5[:, 0], w6[:, 0], atol=1e-9 * np.abs(w6[:, 0]).max())
    np.testing.assert_allclose(five.modes.frequencies[:2], six.modes.frequencies[:2], rtol=1e-6)
    turned = five.cases.displacements_G[0, :, 3:] @ turn[:, 2]
    assert np.abs(turned).max() < 1e-12 * np.abs(five.cases.displacements_G[0, :, 3:]).max()


def test_unknowns_of_a_plate_and_of_a_box() -> None:
    square = plate(4, 0.01, elements=NONE, supports=HARD)
    free = ShellProblem({**square, "supports": {}})
    assert free.freedom.n_free == 5 * 25
    # the hard support holds rz at the edge anyway: 9 nodes inside, and the turns of the edge
    assert ShellProblem(square).freedom.n_free == 5 * 9 + 4 * 3
    walls = ShellProblem(box((6, 2, 2), elements=NONE))
    tied = ShellProblem(box((6, 2, 2), elements=TIE))
    flat = 6 * 4  # one node in the middle of each wall, at the six stations that are not held
    assert walls.freedom.n_free == tied.freedom.n_free - flat


@pytest.mark.one_end
def test_box_of_five_is_the_limit_of_a_weak_tie() -> None:
    weak = {**TIE, "drilling_factor": 1e-7}
    tip = {"end": {"at": "tip", "kind": "average"}}
    push = {"up": {"end": {"at": "end", "force": [0.0, 0.0, 1.0]}}}
    found = [
        analyse(box(elements=e, links=tip, loads=push)).cases.link_motions_G[0, 0, 2]
        for e in (NONE, weak)
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-4)


def test_free_plate_has_six_rigid_motions() -> None:
    found = analyse(plate(4, 0.01, elements=NONE, frequencies={"count": 2, "free": True}))
    assert found.modes.n_zero == 6
    assert "zero-energy-modes" not in [w["code"] for w in found.warnings]
