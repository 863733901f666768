"""A rotation drive: its row holds half a turn away too, where a start is refused."""

import numpy as np
import pytest
from samples.case_samples import rigid, run_text

from plymotion.solver.dynamics.elements.joints.table import DRIVES
from plymotion.solver.errors import InputError
from plymotion.solver.math.rotations import vector_to_matrix

TEXT = (
    "[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
    + rigid("bar", 2.0, 0.1, {"end": (0, 0, 0)})
    + '[joints.motor]\nkind = "revolute"\nbetween = ["ground.O", "bar.end"]\n'
    + "drive = { polynomial = [ANGLE] }\n"
    + '[signals.angle]\nkind = "joint"\njoint = "motor"\ncoordinate = "angle"\n'
)


def test_a_start_half_a_turn_away_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"motor \(drive\) assembles half a turn away"):
        run_text(tmp_path, TEXT.replace("ANGLE", str(np.pi)), t_end=0.1, step=0.1)


def test_a_start_nearby_is_closed(tmp_path):
    _, signals, _ = run_text(tmp_path, TEXT.replace("ANGLE", "1.5"), t_end=0.1, step=0.1)
    np.testing.assert_allclose(signals["angle"], 1.5, atol=1e-12)


@pytest.mark.parametrize("angle", [0.3, 2.0, 7.0])
def test_the_side_is_the_cosine_of_what_is_missing(angle):
    one = vector_to_matrix(np.array([0.2, -0.4, 0.7]))
    two = one @ vector_to_matrix(np.array([0.0, 0.0, angle]))
    assert DRIVES["rotation_drive"].side(one, two, 0.5) == pytest.approx(np.cos(angle - 0.5))
