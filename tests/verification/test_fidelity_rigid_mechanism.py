"""Plans of special scenes: rigid bodies alone, signals that are zero."""

from samples.fidelity_samples import Table, pendulum, planned_run

from plymotion.solver.inputs.case.tables.schema import Mechanism
from plymotion.solver.run.inputs import RunSpec
from plymotion.solver.studies.fidelity.answer import answer_text, entry
from plymotion.solver.studies.fidelity.checked_run import checked, plan_of


def rigid_pendulum() -> Table:
    """With the angle of a joint as a signal, which is unwrapped over time."""
    table = pendulum(t_end=0.1, signals=["tip_x", "angle"], accuracy=1e-3)
    inertia = [[1e-4, 0.0, 0.0], [0.0, 1e-2, 0.0], [0.0, 0.0, 1e-2]]
    places = {name: {"position": [x, 0.0, 0.0]} for name, x in (("root", 0.0), ("tip", 0.6))}
    body = {"kind": "rigid", "mass": 0.6, "inertia": inertia, "interfaces": places}
    angle = {"kind": "joint", "joint": "hinge0", "coordinate": "angle"}
    signals = {"tip_x": table["signals"]["tip_x"], "angle": angle}
    del table["joints"]["hinge0"]["drive"]
    return {**table, "bodies": {"link0": body}, "signals": signals}


def test_the_tolerance_is_chosen_and_checked() -> None:
    mechanism = Mechanism.model_validate(rigid_pendulum())
    answer = checked(plan_of(RunSpec("sample", "planned", mechanism, {}), {}))
    assert answer.verdict == "met"
    assert answer.plan.bodies == {}
    text = answer_text(answer)
    assert "all bodies are rigid, the tolerance alone is chosen" in text
    assert "stiffening" not in text
    assert len(entry(answer)["not_checked"]) == 1


def test_a_signal_across_the_plane_of_motion_is_zero() -> None:
    """It is rounding, to which no model is accurate."""
    table = pendulum(t_end=0.1, signals=["across"], accuracy=1e-3)
    table["signals"]["across"] = {"kind": "position", "at": "link0.tip", "component": "z"}
    answer = checked(plan_of(*planned_run(table)))
    assert answer.verdict == "met"
    assert answer.plan.bodies["link0"].rigid
    assert "Estimated error of across: chosen model 0.0e+00" in answer_text(answer)
    assert "the signal is zero to rounding or noise" in answer_text(answer)
