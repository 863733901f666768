"""Plans: rigid where that is enough, flexible where it is not, and checked by a richer run."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from samples.fidelity_samples import Table, pendulum, planned_run, slider_crank, true_signals

from plymotion.solver.math.compiled import statistics
from plymotion.solver.mechanism.build import build
from plymotion.solver.package import ModalPackage
from plymotion.solver.run.inputs import RunSpec
from plymotion.solver.studies.fidelity.answer import Answer, answer_text, entry
from plymotion.solver.studies.fidelity.checked_run import checked, plan_of
from plymotion.solver.studies.fidelity.checking import Checking
from plymotion.solver.studies.fidelity.comparison import difference, scales
from plymotion.solver.studies.fidelity.indicators.response import modal_loads
from plymotion.solver.studies.fidelity.plan import BodyPlan, Rich, check_plan
from plymotion.solver.studies.fidelity.trial import horizon
from plymotion.solver.studies.tolerances import LADDER_COST

SCENES = {
    "stiff": (pendulum(t_end=0.2), "stiff"),
    "soft": (pendulum(t_end=0.2), "soft"),
    "bending": (pendulum(t_end=0.2, signals=["bending"]), "stiff"),
}


def worst(signal: np.ndarray, exact: np.ndarray) -> float:
    """Return the largest difference, of the largest value."""
    return float(np.abs(signal - exact).max() / np.abs(exact).max())


@cache
def answer_of(name: str) -> Answer:
    table, side = SCENES[name]
    return checked(plan_of(*planned_run(table, side)))


@cache
def truth(name: str) -> dict[str, np.ndarray]:
    """Signals of a scene."""
    return true_signals(*SCENES[name], 1e-7)


def test_a_stiff_machine_is_rigid() -> None:
    answer = checked(plan_of(*planned_run(pendulum(speed=2.0, t_end=0.5), "stiff", 73e12)))
    assert answer.plan.bodies["link0"].rigid
    assert not answer.plan.stiffening
    assert answer.verdict == "met"


@pytest.mark.parametrize("name", list(SCENES))
def test_an_accepted_plan_has_the_accuracy_and_the_check_estimates_it(name: str) -> None:
    answer, exact = answer_of(name), truth(name)
    assert answer.verdict == "met"
    assert answer.trial is not None
    assert answer.estimate is not None
    values = np.array([exact[signal] for signal in answer.names])
    sizes = scales("pointwise", values)
    true = difference("pointwise", answer.trial.signals, values) / sizes
    assert true.max() <= 1e-2
    assert 0.5 <= answer.estimate.max() / true.max() <= 3.0
    delivered = answer.delivered
    assert delivered is not None
    assert (difference("pointwise", delivered.signals, values) / sizes).max() < true.max()


def test_the_stated_error_of_a_joint_force_holds() -> None:
    """The undamped vibrations of a check at its tolerance had 2.4e-3 of the force where the
    rigid model had 1e-3: both differ by 1.8e-3, which was stated of the check.
    """
    table = slider_crank(30.0, 0.15, accuracy=0.1)
    truth = true_signals(table, "soft", 1e-8)["force"]
    answer = checked(plan_of(*planned_run(table, "soft")))
    model, *checks = (worst(signals[0], truth) for _, _, signals in answer.tried)
    stated = entry(answer)["delivered"]["error_at_most"]["force"]
    assert answer.verdict == "met"
    assert model < checks[0] < answer.estimates["force"] == stated
    assert answer.delivered is not None
    assert worst(answer.delivered.signals[0], truth) == checks[-1] < 0.5 * checks[0]


def test_a_joint_force_is_not_accepted_by_one_check() -> None:
    """The budget is used up after the first one."""
    answer = plan_of(*planned_run(slider_crank(30.0, 0.15, accuracy=0.1), "soft"))
    checking = Checking(answer, 0.1, "pointwise", 60.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Checking, "left", lambda self: 0.0 if self.answer.check else 60.0)
        assert checking.settled()
    assert answer.verdict == "not met"
    assert "has not settled at rtol 3e-05" in answer.reason
    assert f"it needs about {60.0 + LADDER_COST * answer.pair[1].cpu:.2g} s" in answer.reason
    assert "quasi-static" not in answer.reason  # it begins so
    sudden = answer.spec.changed({"solver.start": "positions"})
    advised = Checking(replace(answer, spec=sudden), 0.1, "pointwise", 60.0)._unsettled()
    assert 'link0 begins undeformed under loads: `solver.start = "quasi-static"`' in advised
    assert entry(answer)["delivered"] == {"run": "check", "error_at_most": {"force": None}}


def knocked(size: float, at: str, direction: list[float], t_end: float) -> Table:
    """A slider-crank that a force of `size` N sets vibrating."""
    table = slider_crank(30.0, t_end)
    law = {"table": {"times": [0.0, 0.01, 0.0101, t_end], "values": [0.0, 0.0, size, size]}}
    table["forces"] = {"knock": {"kind": "force", "at": at, "direction": direction, "law": law}}
    return table


def exact_signal(answer: Answer) -> np.ndarray:
    """The first signal of an answer with all modes."""
    trial = answer.run(replace(check_plan(answer.plan, answer.study.check), rtol=1e-8))
    assert trial is not None
    return trial.signals[0]


@cache
def bent_rod() -> tuple[RunSpec, dict[str, ModalPackage]]:
    """A rod whose deflection is 1/19000 of the mechanism."""
    table = knocked(0.5, "link0.mid", [0.0, 1.0, 0.0], 0.05)
    table["fidelity"]["signals"] = ["bending"]
    return planned_run(table, "soft")


def test_checks_of_small_deflections_end_where_two_agree() -> None:
    """The first check, of a thousandth of the accuracy, has an error of twice the accuracy."""
    answer = plan_of(*bent_rod())
    own = answer.plan.rtol
    exact = exact_signal(answer)
    answer = checked(answer)
    errors = [worst(s[0], exact) for name, _, s in answer.tried if "9+10" in name]
    assert answer.verdict == "met"
    assert errors[0] > 0.02
    assert answer.check is not None
    assert answer.trial is not None
    assert answer.check.plan.rtol == own
    error = worst(answer.trial.signals[0], exact)
    assert error < answer.estimates["bending"] <= 0.01
    assert worst(answer.check.signals[0], exact) < 1e-3


def test_checks_of_a_joint_force_differ_in_their_steps() -> None:
    """Steps of `max_step` damp a vibration: those of three tolerances are equal, and so are the
    checks, whose error of 8e-5 made the estimate smaller than the error of the model.
    """
    table = knocked(0.1, "slider.pin", [1.0, 0.0, 0.0], 0.03)
    table["solver"]["max_step"] = 2e-4
    answer = plan_of(*planned_run(table, "soft"))
    exact = exact_signal(answer)
    answer = checked(answer)
    assert answer.verdict == "met"
    assert answer.trial is not None
    assert worst(answer.trial.signals[0], exact) < answer.estimates["force"] < 0.002


def test_tolerances_of_checks_have_that_of_the_model_to_the_last_digit() -> None:
    """A check whose tolerance is larger by round-off would call for another one."""
    answer = plan_of(*bent_rod())
    for accuracy in np.geomspace(1e-3, 1e-2, 50).tolist():
        checking = Checking(answer, accuracy, "pointwise", 60.0)
        assert checking._rtol in [checking._tolerance(k) for k in range(9)]
        assert 1e-5 < checking._tolerance(0) <= 3e-5


def test_all_modes_are_the_model_where_the_budget_does_not_split_an_error() -> None:
    """They have run; a check of the next tolerance is not begun if the budget would not end it."""
    answer = plan_of(*bent_rod())
    checking = Checking(answer, 1e-2, "pointwise", 60.0)
    assert not checking.settled()
    check = answer.check
    assert check is not None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Checking, "left", lambda _: 0.5 * check.cpu)
        assert checking.promote()
        assert answer.plan == check.plan
        assert checking.settled()
        assert answer.trial is answer.check is check
        assert answer.verdict == "met"
        assert not checking.promote()
        patch.setattr(Checking, "left", lambda _: 10.0 * check.cpu)
        assert checking.promote()  # nothing is left but the check
    assert answer.check.plan == replace(check.plan, rtol=answer.check.plan.rtol)
    assert answer.check.plan.rtol == pytest.approx(check.plan.rtol / 3.0, rel=1e-15)


def test_a_tighter_request_takes_more_of_the_model() -> None:
    loose = answer_of("soft")
    table, side = SCENES["soft"]
    tight = plan_of(
        *planned_run({**table, "fidelity": {**table["fidelity"], "accuracy": 1e-4}}, side)
    )
    first = plan_of(*planned_run(table, side))
    for name, body in first.plan.bodies.items():
        assert len(tight.plan.bodies[name].vibrations) >= len(body.vibrations)
    assert tight.plan.rtol < loose.plan.rtol


def test_two_runs_of_a_case_give_the_same_plan() -> None:
    table, side = SCENES["soft"]
    assert checked(plan_of(*planned_run(table, side))).plan == answer_of("soft").plan


def test_the_base_motion_leaves_no_loads_on_the_frames() -> None:
    """The rich mechanism has the mass and inertia of the rigid one: only modes are loaded."""
    answer = answer_of("soft")
    base = answer.study.base
    model = build(
        answer.spec.mechanism, {n: r.package for n, r in answer.study.model.items()}
    ).model
    p = modal_loads(base, model)
    assert np.abs(p[:, :6]).max() < 1e-9 * np.abs(p[:, 6:]).max()


def test_an_impossible_request_is_refused_with_a_result() -> None:
    table = pendulum(t_end=0.02, signals=["force"], accuracy=1e-7, budget=1.0)
    answer = checked(plan_of(*planned_run(table, "soft")))
    assert answer.verdict == "not met"
    assert answer.reason
    assert answer.delivered is not None
    found = entry(answer)
    assert found["verdict"] == "not met"
    assert "The request is NOT met" in answer_text(answer)
    assert "bound" not in answer_text(answer)


def test_a_model_without_modes_in_the_plane_starts_quasi_statically() -> None:
    """At 70 rad/s two modes across the plane and stiffening: the shape is the undeformed one."""
    table = pendulum(t_end=0.02, signals=["force"], accuracy=0.1)
    table["joints"]["hinge0"]["drive"] = {"speed": 70.0}
    table["bodies"]["link0"]["angular_velocity"] = [0.0, 0.0, 70.0]
    table["solver"]["start"] = "quasi-static"
    table["masses"]["load"]["mass"] = 0.3
    answer = plan_of(*planned_run(table, "soft"))
    few = {"link0": BodyPlan(("bending-xz 1", "bending-xz 2"))}
    answer.plan = replace(answer.plan, bodies=few, stiffening=True)
    kept = checked(replace(answer), promote=False)  # as a plan that the user has edited
    assert kept.verdict == "met"
    assert kept.delivered is not None
    # the load at 0.6 m and the link, whose centre is at 0.3 m, turn at 70 rad/s
    link = 0.6 * 0.04 * 0.01 * 2700.0
    expected = (0.3 * 0.6 + link * 0.3) * 70.0**2
    assert np.abs(kept.delivered.signals).max() == pytest.approx(expected, rel=0.1)


def test_loading_compiled_functions_takes_nothing_from_the_budget(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first run after an installation compiles for longer than the budget."""
    checking = Checking(answer_of("soft"), 1e-2, "pointwise", 10.0)
    left = checking.left()
    monkeypatch.setattr(statistics, "load_s", statistics.load_s + 20.0)  # of what was spent
    assert checking.left() == pytest.approx(left + 20.0, abs=1.0)


def test_static_shapes_are_those_of_the_loads_that_act() -> None:
    """The largest shapes represent the quasi-static response to round-off."""
    rich: Rich = answer_of("soft").study.model["link0"]
    shapes = rich.rest([])
    worth = rich.energies(shapes)
    kept = shapes[:, worth > 1e-9 * worth.max()]
    left = rich.eta.T - kept @ np.linalg.lstsq(kept, rich.eta.T, rcond=None)[0]
    assert np.abs(left).max() < 1e-6 * np.abs(rich.eta).max()
    assert kept.shape[1] <= 8


def test_the_horizon_is_where_a_tiny_change_has_grown() -> None:
    """A regular motion has none; for an accuracy as tiny as the change it comes at once."""
    answer = answer_of("bending")
    assert answer.horizon is None
    assert answer.trial is not None
    early = horizon(answer.trial, answer.names, 1e-8)
    assert early is not None
    assert 0.0 < early < 0.4
