"""A four-bar mechanism with a tilted hinge: locked when rigid, moving when flexible."""

import numpy as np
import pytest
from samples.case_samples import case_runs, run_case

from plymotion.solver.errors import InputError


@pytest.fixture(scope="module")
def runs(repository, tmp_path_factory):
    return case_runs(repository, "misaligned-four-bar", tmp_path_factory.mktemp("build"))


def test_rigid_bars_are_locked_and_the_run_says_so(runs):
    _, s, summary = run_case(runs / "rigid.json")
    assert summary["checks"]["degrees_of_freedom"] == 0
    assert "mechanism-locked" in [w["code"] for w in summary["warnings"]]
    assert np.abs(s["crank_angle"]).max() < 1e-9


def test_a_drive_on_rigid_bars_is_refused(runs, tmp_path):
    from plymotion.solver.run.execution import execute, read_run

    spec = read_run(runs / "rigid.json").changed({"joints.A.drive": {"speed": -0.6}})
    with pytest.raises(InputError, match="nothing can follow A"):
        execute(spec, progress=False)


def test_approximate_positions_of_flexible_bars_are_closed(runs):
    """Frames alone leave what the tilted hinge forbids of a correction; the bars take that up."""
    from plymotion.solver.run.execution import execute, read_run

    apart = {"ground.D.position": [0.24001, 1e-5, 0.0], "solver.t_end": 0.02}
    spec = read_run(runs / "flexible.json").changed(apart)
    result, summary = execute(spec, progress=False)
    assert summary["completed"]
    assert result.violations["position"][0] < 1e-9
    assert result.energies["strain"][0] < 1e-3
    far = read_run(runs / "flexible.json").changed({"ground.D.position": [0.27, 0.0, 0.03]})
    with pytest.raises(InputError, match="cannot be assembled"):
        execute(far, progress=False)


@pytest.mark.parametrize("stiffer", [1e-6, 1e6])
def test_the_same_deformation_closes_bars_of_any_stiffness(runs, stiffer):
    """A strain energy of 1 J was the unit: modes softer than that were all alike."""
    from plymotion.solver.mechanism.consistent import with_closed_joints
    from plymotion.solver.run.execution import read_run
    from plymotion.solver.run.preparation import prepare

    spec = read_run(runs / "flexible.json")
    ready = prepare(spec.mechanism, spec.packages)
    model, y = ready.model, ready.y0.copy()
    y[int(model.pos_start[0]) + 7] = 1e-4  # of the deformation of the first bar
    found = [
        with_closed_joints(model._replace(K_qq=factor * model.K_qq), y, elastic=True)
        for factor in (1.0, stiffer)
    ]
    np.testing.assert_allclose(found[1], found[0], atol=1e-12)


def test_flexible_bars_turn(runs):
    """The crank turns, hinge C leaves the plane, and closes again after a whole turn."""
    t, s, summary = run_case(runs / "flexible.json")
    assert summary["completed"]
    at_speed = t >= 1.0
    np.testing.assert_allclose(s["crank_angle"][at_speed], -0.6 * (t[at_speed] - 0.5), atol=1e-6)
    assert 4e-3 < np.abs(s["C_z"]).max() < 5e-3
    turn = 2 * np.pi / 0.6
    again = at_speed & (t + turn <= t[-1])
    assert again.sum() > 50
    for name in ("C_x", "C_y", "C_z", "torque", "moment"):
        later = np.interp(t[again] + turn, t, s[name])
        size = np.ptp(s[name])
        np.testing.assert_allclose(later, s[name][again], atol=0.01 * size, err_msg=name)
