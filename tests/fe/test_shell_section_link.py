"""Loads at the open end of a thin-walled section: the stresses of Saint-Venant."""

from typing import Any

import numpy as np
import pytest
from shell_layups import BOX_MATERIAL, BOXES, WALL
from shell_model import laminate
from shell_specs import METAL, SCRIPTS, plate

from plymotion.preprocess.shell.analysis import analyse
from plymotion.preprocess.shell.errors import ShellError
from plymotion.preprocess.shell.freedom import Freedom
from plymotion.preprocess.shell.problem import ShellProblem

QUADS = {"element": "quadrilateral"}


def box(layup: str, kind: str, n: tuple[int, int, int] = (40, 4, 3)) -> dict[str, Any]:
    """The paper's box, clamped at its root, with a link at its open tip."""
    size = dict(zip(("n_length", "n_width", "n_height"), n, strict=True))
    moments = {"Fy": [0.0, 1.0, 0.0], "Fz": [0.0, 0.0, 1.0]}
    turns = {"T": [1.0, 0.0, 0.0], "My": [0.0, 1.0, 0.0], "Mz": [0.0, 0.0, 1.0]}
    return {
        "mesh": {"file": str(SCRIPTS / "box-beam.py"), "parameters": size, **QUADS},
        "materials": {"ply": BOX_MATERIAL},
        "laminates": {w: laminate("ply", p, WALL, "energy-1d") for w, p in BOXES[layup].items()},
        "regions": {w: {"laminate": w, "axis": [1.0, 0.0, 0.0]} for w in BOXES[layup]},
        "supports": {"root": {"at": "root", "fixed": "all"}},
        "links": {"tip": {"at": "tip", "kind": kind}},
        "loads": {
            **{k: {"tip": {"at": "tip-link", "force": v}} for k, v in moments.items()},
            **{k: {"tip": {"at": "tip-link", "moment": v}} for k, v in turns.items()},
        },
    }


def turned(layup: str, kind: str) -> np.ndarray:
    """Motion of the tip's point along each of its loads."""
    spec = box(layup, kind)
    spec["links"] = {"tip-link": spec["links"]["tip"]}
    found = analyse(spec).cases
    rows = [1, 2, 3, 4, 5]
    return found.link_motions_G[range(5), 0, rows]


@pytest.mark.parametrize("layup", ["0", "cas15", "cus15"])
def test_twist_of_an_open_box(layup: str) -> None:
    """The rigid link holds the section in shape; the averaging link distorts it."""
    rigid, average, section = (turned(layup, kind) for kind in ("rigid", "average", "section"))
    assert section / rigid == pytest.approx(np.ones(5), rel=0.01)
    assert section[2] / rigid[2] == pytest.approx(1.0, rel=0.005)
    assert average[2] / rigid[2] > 1.1


def test_rigid_motions_and_work() -> None:
    spec = box("cas15", "section", (4, 2, 2))
    spec["links"]["tip"]["point"] = [1.1, 0.02, -0.01]
    problem = ShellProblem(spec | {"loads": {}})
    freedom = Freedom(problem.mesh, problem.links)
    rigid = freedom.rigid_motions()
    follow = freedom.expanded(rigid[freedom.free])
    assert np.abs(follow - rigid).max() < 1e-10
    force = np.zeros((freedom.n_dof, 6))
    force[-6:] = np.eye(6)
    nodal = freedom.gathered(force)
    assert np.abs(rigid[freedom.free].T @ nodal - rigid[-6:].T).max() < 1e-10


def test_open_section_and_refusals() -> None:
    """A slit tube carries torsion by the twisting moments of its walls; no straight edge does."""
    size = {"radius": 0.1, "length": 1.0, "first_deg": 20.0, "second_deg": 320.0}
    tube = {
        "mesh": {
            "file": str(SCRIPTS / "cylinder.py"),
            "parameters": {**size, "n_length": 20, "n_around": 24},
            **QUADS,
        },
        "materials": {"metal": METAL},
        "regions": {"all": {"material": "metal", "thickness": 0.005}},
        "supports": {"root": {"at": "near", "fixed": "all"}},
        "links": {"tip": {"at": "far", "kind": "section"}},
        "loads": {"T": {"tip": {"at": "tip", "moment": [1.0, 0.0, 0.0]}}},
    }
    found = analyse(tube).cases
    assert found.reactions_G[0, 0, 3] == pytest.approx(-1.0, rel=1e-6)
    assert found.link_motions_G[0, 0, 3] > 0.0
    flat = plate((4, 2), 0.01, links={"tip": {"at": "right", "kind": "section"}})
    with pytest.raises(ShellError, match=r"links.tip.at = 'right': a straight line; .*average"):
        ShellProblem(flat)
    flat["links"]["tip"]["at"] = "plate"
    with pytest.raises(ShellError, match="a surface; a section link needs a curve"):
        ShellProblem(flat)
