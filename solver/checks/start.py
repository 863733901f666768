"""Whether bodies start in a shape that the loads at t = 0 do not want."""

from collections.abc import Iterator

from ..dynamics.analysis.held import (
    held_deformations,
    is_moving,
    joined_deformations,
    motions_without_strain,
)
from ..dynamics.evaluation.laws import law_values
from ..math.arrays import Array
from ..mechanism.consistent.initial import undeformed
from ..results.codes import LOADED_START
from ..results.finding import Finding
from .finished import FinishedRun

MOST = 400  # velocity coordinates: the eigenproblem of more would be felt
QUASI_STATIC = (
    'With solver.start = "quasi-static" the bodies begin in the shape that the loads of this '
    "motion call for. "
)


def start_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield the body whose loads at t = 0 strain it most suddenly, if that matters in the run.

    A body that starts in another shape than its loads call for vibrates about that shape. The
    energy of this difference is compared with the largest strain energy of the body. A body whose
    `modal_coordinates` the case gives has the shape that is meant. A quasi-static start has the
    shape that its loads call for.
    """
    if not run.model.n_mode.any() or run.mechanism.solver.start == "quasi-static":
        return
    worst, where = 0.0, -1
    for i, change in enumerate(_called_for(run)):
        if not change.size:
            continue  # rigid; without a name if it is a heavy point mass
        body = run.mechanism.bodies.get(run.built.body_names[i])
        if not getattr(body, "modal_coordinates", None):
            stiffness = run.packages[run.built.body_names[i]].stiffness
            peak = max(float(((q @ stiffness) * q).sum(axis=1).max()) for _, q in run.modes(i))
            share = float(change @ stiffness @ change) / peak if peak > 0.0 else 0.0
            if share > worst:
                worst, where = share, i
    if worst > LOADED_START.limit:
        name = run.built.body_names[where]
        text = (
            f"{name}: the body does not start in the shape that belongs to the loads at t = 0. "
            f"They act suddenly; the vibration about that shape has {worst:.2g} of the largest "
            f"strain energy of the run (expected below {LOADED_START.limit:g}). {_remedy(run)}"
        )
        yield LOADED_START.finding(text, body=name, t=0.0, value=worst)


def _called_for(run: FinishedRun) -> list[Array]:
    """Return the change of the shape of each body that its loads at the start call for."""
    model, t, y = run.model, float(run.solution.t[0]), run.solution.y[0]
    if run.independent and model.n_vel <= MOST:
        rigid = undeformed(model, y, t)
        free = motions_without_strain(model, t, rigid)
        # Of a loop that is over-constrained but for its deformation, rigid bodies would be locked.
        if free > motions_without_strain(model, t, y):
            return joined_deformations(model, t, y, free)
    return held_deformations(model, t, y)


def _remedy(run: FinishedRun) -> str:
    """Return which start the run has, which one may be meant, and how to get it."""
    begins = ", ".join(_accelerating(run))
    if begins:
        gentle = (
            f"{begins}: its law begins with an acceleration; smooth_step and ramp begin without"
        )
        if run.mechanism.solver.start == "equilibrium":
            return f"The run starts in equilibrium at rest, but {gentle}"
        return (
            f'{gentle}. With solver.start = "quasi-static" the bodies begin in the shape for it; '
            'for weight and springs at rest set "equilibrium"'
        )
    quasi = "" if run.mechanism.solver.start == "quasi-static" else QUASI_STATIC
    if is_moving(run.model, run.solution.y[0]):
        return (
            "The run starts in motion, in the shape that the case gives (undeformed by default). "
            f'{quasi}If a steady spin is meant, set solver.spin and solver.start = "equilibrium"; '
            "for another shape give modal_coordinates"
        )
    return (
        "The run starts in the shape that the case gives (undeformed by default), as if it were "
        f"released at t = 0. {quasi}If a start at rest under these loads is meant, set "
        'solver.start = "equilibrium"'
    )


def _accelerating(run: FinishedRun) -> list[str]:
    """Return the driven joints whose law has an acceleration at t = 0, by their key."""
    laws, model = law_values(run.model, float(run.solution.t[0])), run.model
    names = [
        name.partition(" ")[0]  # without "(drive)"
        for name, law in zip(run.built.joint_names, model.joint_law.tolist(), strict=False)
        if law >= 0 and abs(laws[law, 2]) > 0.0
    ]
    return [f"joints.{name}" for name in dict.fromkeys(names)]
