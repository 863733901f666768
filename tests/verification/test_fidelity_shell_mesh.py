"""The mesh of a shell: its error stays in the estimate when the model takes the finer mesh.

A beam of few elements stands for the shell, because packages of shells need FEniCSx.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from samples.fidelity_samples import INTERFACES, pendulum, planned_run, true_signals

from plymotion.solver.inputs.case.tables.bodies import ShellBody
from plymotion.solver.studies.fidelity.answer import Answer
from plymotion.solver.studies.fidelity.checked_run import checked, plan_of
from plymotion.solver.studies.fidelity.comparison import difference, scales
from plymotion.solver.studies.fidelity.plan import BodyPlan, Plan, with_values

SHELL = ShellBody.model_validate(
    {
        "kind": "shell",
        "shell": "plate.toml",
        "modes": [{"kind": "lowest", "count": 4}],
        "interfaces": {name: {"at": name} for name in INTERFACES},
    }
)
MODES = BodyPlan(("bending-xy 1", "bending-xy 2", "bending-xy 3"), 4, True)
MESHES = 2, 4  # elements of the two packages
T_END = 0.05  # [s]


@cache
def truth() -> np.ndarray:
    """The signal (1, k) with the finest mesh."""
    table = pendulum(t_end=T_END, signals=["bending"])
    return np.array([true_signals(table, "soft", 1e-6)["bending"]])


def judged(accuracy: float, mesh: str, *, shell: bool = True) -> tuple[Answer, float, float]:
    """Answer for a plan with a mesh, the estimate, and the true error of what is delivered."""
    table = pendulum(t_end=T_END, signals=["bending"], accuracy=accuracy)
    (spec, _), (finer, _) = (planned_run(table, "soft", elements=n) for n in MESHES)
    if shell:
        spec = replace(spec, mechanism=with_values(spec.mechanism, bodies={"link0": SHELL}))
    answer = plan_of(spec, finer.packages)
    answer.plan = Plan({"link0": replace(MODES, mesh=mesh)}, True, 1e-5)
    answer = checked(answer, promote=False)
    assert answer.estimate is not None
    assert answer.delivered is not None
    true = difference("pointwise", answer.delivered.signals, truth()) / scales("pointwise", truth())
    return answer, float(answer.estimate.max()), float(true.max())


def test_the_finer_mesh_does_not_hide_its_error() -> None:
    (_, coarse, _), (answer, fine, true) = judged(1e-4, "model"), judged(1e-4, "check")
    assert answer.verdict == "not met"
    assert "the two meshes of link0 differ" in answer.reason
    assert fine == pytest.approx(coarse, rel=0.2)
    assert fine > true
    assert judged(1e-4, "check", shell=False)[1] < 0.2 * fine  # the error that was hidden


def test_a_mesh_that_is_fine_enough_is_accepted() -> None:
    answer, estimate, true = judged(1e-2, "check")
    assert answer.verdict == "met"
    assert true < estimate < 1e-2
