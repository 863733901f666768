"""What a request gets that is not met or leaves the theory, and what a check takes for it."""

from dataclasses import replace

import numpy as np
import pytest
from samples.fidelity_samples import pendulum, planned_run
from samples.recovery_samples import STEEL, STEEL_STRENGTH, plies_of, rectangle_recovery

from plymotion.solver.dynamics.evaluation.accelerations import assemble, masses_and_jacobians
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.tables.schema import Mechanism
from plymotion.solver.studies.fidelity.answer import answer_text, entry, fidelity_line
from plymotion.solver.studies.fidelity.checked_run import checked, plan_of
from plymotion.solver.studies.fidelity.checking import Checking
from plymotion.solver.studies.fidelity.indicators.base_motion import telling_times
from plymotion.solver.studies.fidelity.plan import (
    BodyPlan,
    Plan,
    check_plan,
    kind_of,
    vibration_labels,
)


def short(**fidelity):
    return planned_run(pendulum(t_end=0.1, signals=["force"], **fidelity), "soft")


@pytest.mark.parametrize("signal", ["force", "tip_y"])
def test_a_refusal_delivers_all_modes_that_respond(signal):
    table = pendulum(t_end=0.1, signals=[signal], accuracy=1e-3)
    answer = plan_of(*planned_run(table, "soft"))
    answer.plan = Plan({"link0": BodyPlan()}, False, 1e-4)
    answer = checked(answer, promote=False)
    assert answer.verdict == "not met"
    assert answer.check is not None
    assert answer.delivered is answer.check
    package = answer.check.spec.packages["link0"]
    eta = answer.study.check["link0"].eta
    assert package.n_mode == np.sum(np.abs(eta).max(axis=0) > 0.0)  # zero: do not respond
    assert "The result of the check is delivered" in answer_text(answer)
    assert entry(answer)["delivered"]["run"] == "check"
    assert entry(answer)["delivered"]["error_at_most"] == {signal: None}  # it may change
    words = f"model {answer.estimates[signal]:.1e}; delivered run not estimated"
    assert words in answer_text(answer)


def long(**fidelity):
    """A run of 1000 steps: time is looked at after every 200."""
    table = pendulum(t_end=0.1, signals=["force"], **fidelity)
    table["solver"]["max_step"] = 1e-4
    return planned_run(table, "soft")


def test_planning_ends_with_the_budget():
    with pytest.raises(InputError, match=r"fidelity.budget = 1e-09: .* the whole run takes about"):
        plan_of(*long(budget=1e-9))


@pytest.mark.provokes("budget-used-up")
@pytest.mark.parametrize("what", ["model", "check"])
def test_model_and_check_end_with_the_budget(what):
    """The run that takes longer is stopped, and no other one begins."""
    answer = plan_of(*long(accuracy=1e-3))
    checking = Checking(answer, 1e-3, "pointwise", 60.0)
    of_model, of_check = (1e-9, 0.0) if what == "model" else (60.0, 1e-9)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Checking, "left", lambda _: of_check if answer.trial else of_model)
        assert checking.settled()
    assert answer.verdict == "not met"
    assert f"the run of the {what} stopped at t = " in answer.reason
    assert "s of CPU time are used up; the whole run takes about" in answer.reason
    assert answer.delivered is answer.trial
    assert entry(answer)["delivered"] == {"run": "model", "error_at_most": {"force": None}}
    _, summary = answer.delivered.outcome()
    assert summary["completed"] == (what == "check")
    stopped = answer.trial if what == "model" else answer.check
    assert stopped is not None
    _, summary = stopped.outcome()
    assert "budget-used-up" in [finding["code"] for finding in summary["warnings"]]


def test_a_check_takes_all_vibrations_that_respond():
    """Whatever the plan has; those across the plane of the motion are left out."""
    answer = plan_of(*short(accuracy=1e-3))
    package = answer.study.check["link0"].package
    kinds = {kind_of(label) for label in answer.study.indicators.ranked("link0")}
    every = [label for label in vibration_labels(package) if kind_of(label) in kinds]
    assert len(every) < len(vibration_labels(package))
    for few in ((), every[:4]):
        plan = replace(answer.plan, bodies={"link0": BodyPlan(tuple(few), 2)})
        check = check_plan(plan, answer.study.check).bodies["link0"]
        assert list(check.vibrations) == every
        assert (check.ringing, check.mesh, check.rigid) == (True, "check", False)


def test_a_body_that_turns_far_is_told_with_the_segments_it_needs():
    table = pendulum(t_end=0.3, speed=3.0, signals=["tip_x"], accuracy=1e-1)
    answer = checked(plan_of(*planned_run(table, "soft", 73e9 / 60)))
    assert answer.verdict == "met"  # of this theory
    assert "divide the beam by segments = 2" in answer.beyond[0]
    assert entry(answer)["beyond_theory"] == answer.beyond
    assert f"Beyond the theory of both runs: {answer.beyond[0]}." in answer_text(answer)


def test_a_spinning_body_without_second_order_data_is_not_met():
    table = pendulum(speed=130.0, t_end=0.2, signals=["bending"], accuracy=0.3)
    spec, check = planned_run(table, "soft")
    answer = checked(plan_of(spec, check))
    assert answer.verdict == "met"
    linear = [
        {name: replace(package, second_order=None) for name, package in known.items()}
        for known in (spec.packages, check)
    ]
    answer = checked(plan_of(replace(spec, packages=linear[0]), linear[1]))
    assert answer.verdict == "not met"
    assert answer.reason.startswith("link0 would stiffen by spin")
    assert "geometric stiffening: no second-order data (link0)" in entry(answer)["not_checked"]


def test_a_body_of_one_package_is_said_not_to_be_checked():
    table = pendulum(t_end=0.1)
    spec, _ = planned_run(table)
    table["bodies"]["link0"] = {"kind": "imported", "import": "link.toml"}
    spec = replace(spec, mechanism=Mechanism.model_validate(table))
    words = entry(plan_of(spec, spec.packages))["not_checked"]
    assert "bodies of one package: its mesh and its modes (link0)" in words


def test_a_strength_ratio_that_is_infinite_at_the_start_can_be_met():
    table = pendulum(t_end=0.2, signals=["reserve"], accuracy=0.1)
    table["signals"]["reserve"] = {"kind": "strength_ratio", "body": "link0"}
    steel = {"steel": {**STEEL, "strength": STEEL_STRENGTH}}
    recovery = rectangle_recovery(0.01, 0.04, plies_of(("steel", 0.0)), steel)
    spec, check = planned_run(table, "soft")
    model, check = (
        {
            name: replace(package, sections=(replace(package.sections[0], recovery=recovery),))
            for name, package in packages.items()
        }
        for packages in (spec.packages, check)
    )
    answer = plan_of(replace(spec, packages=model), check)
    assert not answer.plan.bodies["link0"].rigid
    indicated = answer.study.indicators
    assert indicated.amplified > 100.0  # small deflections: checks have falling tolerances
    answer = checked(answer)
    assert answer.verdict == "met"
    assert 0.0 < answer.estimates["reserve"] < 0.1
    assert indicated.scale[0] == pytest.approx(entry(answer)["scale"]["reserve"], rel=0.1)
    checking = Checking(answer, 1e-6, "pointwise", 60.0)
    checking._estimate(np.zeros(1))
    assert checking._met()  # more of the packages does not help
    assert "more `elements` of beams" in answer.reason


def test_modes_across_the_plane_of_a_motion_do_not_respond():
    answer = plan_of(*short())
    labels = {mode.label for mode in answer.study.indicators.modes}
    assert {"bending-xy 1", "axial 1"} <= labels
    assert not any(label.startswith(("bending-xz", "torsion")) for label in labels)


def test_telling_times_have_the_peak_of_a_short_load():
    base = plan_of(*short()).study.base
    between = 7  # no multiple of the regular steps
    peak = base.accelerations.copy()
    peak[between, 1] = 2.0 * np.abs(peak[:, 1]).max() + 1.0
    assert between not in telling_times(base)
    assert between in telling_times(replace(base, accelerations=peak))


def test_mass_matrices_of_many_states_are_those_of_each():
    base = plan_of(*short()).study.base
    rows = [0, 50, 200]
    M, Phi_q = masses_and_jacobians(base.model, base.t[rows], base.y[rows])
    for found, jacobian, k in zip(M, Phi_q, rows, strict=True):
        one = assemble(base.model, float(base.t[k]), base.y[k])
        assert np.array_equal(found, one.M)
        assert np.array_equal(jacobian, one.Phi_q)


def test_a_check_that_stops_by_a_finding_leaves_an_error_that_is_not_estimated():
    """The result of the model is delivered; nothing says that its error is known."""
    answer = checked(plan_of(*short(accuracy=1e-2)), promote=False)
    assert answer.check is not None
    assert answer.trial is not None
    solution = replace(
        answer.check.finished.solution, status="stopped", code="some-code", message="it broke"
    )
    finished = replace(answer.check.finished, solution=solution)
    stopped = replace(answer.check, finished=finished, complete=False)
    again = plan_of(*short(accuracy=1e-2))
    again.plan, again.check = answer.plan, stopped
    checking = Checking(again, 1e-2, "pointwise", 60.0)
    assert checking.settled()  # no promotion helps
    assert again.verdict == "not met"
    assert "the run of the check stopped" in again.reason
    assert "by `some-code` (it broke)" in again.reason
    assert again.delivered is again.trial
    found = entry(again)
    assert found["delivered"] == {"run": "model", "error_at_most": {"force": None}}
    assert "force: chosen model not estimated; delivered run not estimated" in answer_text(again)
    assert "delivered: the chosen model, error not estimated" in fidelity_line(found)
