"""What is promoted after a check."""

from plymotion.solver.studies.fidelity.plan import BodyPlan, Plan
from plymotion.solver.studies.fidelity.trial import Share, promoted, promotions

BENDING = tuple(f"bending-xy {i}" for i in (1, 2, 3, 4, 5))
RANKED = {name: ("bending-xy 1", "bending-xy 3", "bending-xy 2") for name in ("crank", "rocker")}
CHECK = Plan({name: BodyPlan(BENDING, 4, True, "check") for name in RANKED}, True, 1e-7)
RIGID = Plan({name: BodyPlan() for name in RANKED}, True, 1e-6)


def test_what_exceeds_the_accuracy_is_promoted_with_what_exceeds_it_more():
    """A base of 0.3 does not hide a crank of 0.05 if 0.01 is asked for."""
    shares = [Share("vibrations", "crank", 0.3), Share("vibrations", "rocker", 0.05)]
    more = promoted(RIGID, CHECK, RANKED, shares, 0.32, 1e-2)
    assert not any(body.rigid for body in more.bodies.values())
    less = promoted(RIGID, CHECK, RANKED, shares, 0.32, 0.2)
    assert less.bodies["rocker"].rigid


def test_vibrations_follow_by_their_losses_and_then_those_of_the_check():
    """Two at a time; the package of the model does not have the last ones."""
    plan, kept = RIGID, []
    for _ in range(3):
        changes = {(kind, body): more for kind, body, more in promotions(plan, CHECK, RANKED)}
        plan = plan.with_body("crank", **changes["vibrations", "crank"])
        kept.append((plan.bodies["crank"].vibrations, plan.bodies["crank"].mesh))
    first = ("bending-xy 1", "bending-xy 3")
    more = (*first, "bending-xy 2", "bending-xy 4")
    assert kept == [(first, "model"), (more, "check"), ((*more, "bending-xy 5"), "check")]
    assert ("vibrations", "crank") not in {
        (kind, body) for kind, body, _ in promotions(plan, CHECK, RANKED)
    }


def test_all_at_once_leaves_a_plan_that_needs_no_other_check():
    """Without shares, the tolerance waits until nothing else is left."""
    steps = [RIGID]
    while (new := promoted(steps[-1], CHECK, RANKED, [], 0.3, 1e-2)) != steps[-1]:
        steps.append(new)
    kept = [len(step.bodies["crank"].vibrations) for step in steps]
    assert sorted(kept) == kept
    assert kept[:3] == [0, 2, 4]
    assert kept[-1] == len(BENDING)
    tight = [step.rtol < RIGID.rtol for step in steps]
    assert sorted(tight) == tight
    assert tight[-1]
    bodies = [step.bodies for step, tighter in zip(steps, tight, strict=True) if tighter]
    assert all(found == bodies[0] for found in bodies)  # all other promotions came before
