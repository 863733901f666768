"""What is promoted after a check, and which check serves the promoted plan, too."""

from dataclasses import replace
from functools import cache

from samples.fidelity_samples import pendulum, planned_run

from plymotion.solver.studies.fidelity.execution import plan_of
from plymotion.solver.studies.fidelity.plan import BodyPlan, Plan, check_plan, covers, kind_of
from plymotion.solver.studies.fidelity.trial import Share, promoted, promotions

BENDING = tuple(f"bending-xy {i}" for i in (1, 2, 3, 4))
RANKED = {"crank": BENDING, "rocker": BENDING}
CHECK = Plan({name: BodyPlan(BENDING[:3], 4, True, "check") for name in RANKED}, True, 1e-7)
RIGID = Plan({name: BodyPlan() for name in RANKED}, True, 1e-6)


def test_what_exceeds_the_accuracy_is_promoted_with_what_exceeds_it_more():
    """A base of 0.3 does not hide a crank of 0.05 if 0.01 is asked for."""
    shares = [Share("vibrations", "crank", 0.3), Share("vibrations", "rocker", 0.05)]
    more = promoted(RIGID, CHECK, RANKED, shares, 0.32, 1e-2)
    assert not any(body.rigid for body in more.bodies.values())
    less = promoted(RIGID, CHECK, RANKED, shares, 0.32, 0.2)
    assert less.bodies["rocker"].rigid


def test_the_highest_vibrations_stay_with_the_check():
    kinds = {(kind, body): plan for kind, body, plan in promotions(RIGID, CHECK, RANKED)}
    first = kinds["vibrations", "crank"]
    assert first.bodies["crank"].vibrations == BENDING[:2]
    kinds = {(kind, body): plan for kind, body, plan in promotions(first, CHECK, RANKED)}
    assert ("vibrations", "crank") not in kinds
    assert kinds["highest vibrations", "crank"].bodies["crank"].vibrations == BENDING[:3]


def test_all_at_once_leaves_a_plan_that_needs_no_other_check():
    """Without shares, the highest vibrations and the tolerance wait until nothing else is left."""
    more = promoted(RIGID, CHECK, RANKED, [], 0.3, 1e-2)
    assert more.rtol == RIGID.rtol
    assert {body.vibrations for body in more.bodies.values()} == {BENDING[:2]}
    steps = [more]
    while (new := promoted(steps[-1], CHECK, RANKED, [], 0.3, 1e-2)) != steps[-1]:
        steps.append(new)
    kept = [len(step.bodies["crank"].vibrations) for step in steps]
    assert sorted(kept) == kept
    assert kept[-1] == 3
    assert [s.rtol for s in steps if len(s.bodies["crank"].vibrations) == 2] == [1e-6] * kept.count(
        2
    )
    assert steps[-1].rtol < RIGID.rtol


@cache
def checks():
    """Plan, its check, ranks and packages of the check of a pendulum."""
    answer = plan_of(*planned_run(pendulum(t_end=0.05), "soft"))
    ranked = {"link0": answer.study.indicators.ranked("link0")}
    plan = replace(answer.plan, bodies={"link0": BodyPlan(ranked["link0"][:1], 2)})
    return plan, check_plan(plan, ranked, answer.study.check), ranked, answer.study.check


def covered(plan):
    _, check, ranked, packages = checks()
    wanted = replace(check_plan(plan, ranked, packages), rtol=check.rtol)
    return wanted != check, covers(check, wanted, plan, ranked, packages)


def test_a_check_serves_a_promoted_plan_that_still_has_less():
    plan, check, ranked, _ = checks()
    (more,) = (p for kind, _, p in promotions(plan, check, ranked) if kind == "vibrations")
    assert set(more.bodies["link0"].vibrations) > set(plan.bodies["link0"].vibrations)
    assert covered(more) == (True, True)


def test_a_check_does_not_serve_a_plan_that_has_something_more():
    plan, check, ranked, packages = checks()
    every = [
        x for x in check.bodies["link0"].vibrations if kind_of(x) in map(kind_of, ranked["link0"])
    ]
    assert covered(plan.with_body("link0", vibrations=tuple(every))) == (True, False)
    tight = replace(check_plan(plan, ranked, packages), rtol=0.1 * check.rtol)
    assert not covers(check, tight, plan, ranked, packages)
