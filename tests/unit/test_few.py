"""Messages name five at most, and say how many more there are."""

import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.preprocess.beam.beam_body import coarse_mesh_warnings
from plymotion.solver.errors import few, nearest
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import execute, read_run


@pytest.mark.parametrize(
    ("count", "text"), [(0, ""), (1, "0"), (5, "0, 1, 2, 3, 4"), (6, "0, 1, 2, 3, 4 and 1 more")]
)
def test_first_five_and_how_many_more(count: int, text: str) -> None:
    assert few(map(str, range(count))) == text


def test_known_names_of_a_long_list() -> None:
    known = [f"body-{k}" for k in range(17)]
    listed = "body-0, body-1, body-10, body-11, body-12 and 12 more"
    assert nearest("?", known) == f"; known: {listed}"


@pytest.mark.provokes("redundant-constraints")
def test_redundant_joints_of_a_large_mechanism(tmp_path) -> None:
    """Twelve hinges on one axis: five are named."""
    text = rigid("door", 1.0, 1.0, {f"p{k}": [0, 0, k] for k in range(12)})
    for k in range(12):
        text += (
            f"[ground.q{k}]\nposition = [0.0, 0.0, {k}.0]\n"
            f'[joints.hinge-{k:02}]\nkind = "revolute"\nbetween = ["ground.q{k}", "door.p{k}"]\n'
            "axis = [0, 0, 1]\n"
        )
    file = tmp_path / "case.toml"
    file.write_text(HEAD + text + SOLVER.format(t_end=0.01, step=0.01, more=""))
    write_case(load_case(file), tmp_path)
    _, summary = execute(read_run(tmp_path / "runs/base.json"), progress=False)
    (found,) = [w for w in summary["warnings"] if w["code"] == "redundant-constraints"]
    assert found["message"].count("hinge-") == 5
    assert "hinge-04 and 7 more" in found["message"]


def test_coarse_modes_of_a_long_list() -> None:
    labels = tuple(f"mode {k}" for k in range(9))
    (found,) = coarse_mesh_warnings(labels, np.full(9, 0.5), 4)
    assert found["message"].count("mode ") == 5
    assert "and 4 more" in found["message"]
