"""Edges that a support keeps straight in the plane of the shell."""

from typing import Any

import numpy as np
import pytest
from samples.shell_specs import METAL, plate

from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem

STRETCH = 1e-3


def pulled(n: Any, **tables: Any) -> dict[str, Any]:
    """A strip held and displaced along x at its ends, free to contract."""
    supports = {
        "left": {"at": "left", "fixed": ["ux", "uz", "rx", "ry"]},
        "corner": {"at": "corner-00", "fixed": ["uy"]},
        "right": {"at": "right", "fixed": ["ux", "uz"]},
    }
    loads = {"pull": {"right": {"at": "right", "motion": {"ux": STRETCH}}}}
    return plate(n, 0.01, 1.0, 0.5, supports=supports, loads=loads, **tables)


@pytest.mark.parametrize("element", ["triangle", "quadrilateral"])
def test_strip_between_moved_ends_has_an_even_stress(element: str) -> None:
    """Sides that bow between the held nodes made four cells 12 % too soft."""
    spec = pulled((4, 3))
    spec["mesh"]["element"] = element
    spec["mesh"]["parameters"]["distortion"] = 0.2
    found = analyse(spec)
    force = METAL["E"] * 0.01 * 0.5 * STRETCH
    right = found.cases.reactions_G[0, 2]
    assert right == pytest.approx([force, 0.0, 0.0, 0.0, 0.0, 0.0], rel=1e-10, abs=1e-6)
    even = [2.0 * force, 0.0, 0.0]  # per width
    assert found.cases.resultants_E[0, :, :3] == pytest.approx(
        np.broadcast_to(even, (len(found.mesh.cells), 3)), abs=1e-6 * force
    )


def rotations(spec: dict[str, Any], name: str, purpose: str = "loads") -> set[str]:
    """Components of a support at the nodes of a plate."""
    problem = ShellProblem(spec)
    support = next(s for s in problem.supports if s.name == name)
    return {("ux", "uy", "uz", "rx", "ry", "rz")[dof % 6] for dof in support.dofs}


def test_only_edges_that_slide_and_are_held_across() -> None:
    """Not where the edge is held along itself (shear turns it) or not across."""
    both = pulled((4, 3))
    assert rotations(both, "right") == {"ux", "uz", "rz"}
    both["supports"]["along"] = {"at": "right", "fixed": ["uy"]}
    assert rotations(both, "right") == {"ux", "uz"}
    assert rotations(both, "along") == {"uy"}
    both["supports"]["along"]["only"] = "modes"  # it slides in load cases
    assert rotations(both, "right") == {"ux", "uz", "rz"}
    assert rotations(pulled((4, 3), elements={"membrane": "cst"}), "right") == {"ux", "uz"}
