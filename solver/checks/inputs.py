"""Checks of the start: the shape of bodies, and curves through the points of tables."""

from collections.abc import Iterator
from itertools import chain
from typing import TYPE_CHECKING

from ..dynamics.analysis.quasi_static import (
    MOST,
    is_moving,
    motions_without_strain,
    quasi_static_deformations,
    quasi_static_deformations_of_loops,
)
from ..dynamics.evaluation.laws import law_values
from ..inputs.case.expressions import drives, is_along, is_load, law
from ..math import laws
from ..math.arrays import Array
from ..math.rows import column
from ..mechanism.consistent import undeformed
from ..results.codes import LOADED_START, TABLE_OVERSHOOTS, Finding
from .finished_run import FinishedRun

if TYPE_CHECKING:
    from ..inputs.case.tables import laws as laws_of_case
    from ..inputs.case.tables.schema import Mechanism

# Whether bodies start in a shape that the loads at t = 0 do not want.

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
        rigid = undeformed(model, y)
        free = motions_without_strain(model, t, rigid)
        # Of a loop that is over-constrained but for its deformation, rigid bodies would be locked.
        if free > motions_without_strain(model, t, y):
            return quasi_static_deformations_of_loops(model, t, y, free)
    return quasi_static_deformations(model, t, y)


def _remedy(run: FinishedRun) -> str:
    """Return which start the run has, which one may be meant, and how to get it."""
    # The driven joints whose law has an acceleration at t = 0.
    laws, model = law_values(run.model, float(run.solution.t[0])), run.model
    names = [
        name.partition(" ")[0]  # without "(drive)"
        for name, law in zip(run.built.joint_names, model.joint_law.tolist(), strict=False)
        if law >= 0 and abs(laws[law, 2]) > 0.0
    ]
    begins = ", ".join(f"joints.{name}" for name in dict.fromkeys(names))
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


# Whether curves through the points of tables go far beyond these points.

Beyond = tuple[str, float, str]  # key of a table, its overshoot, what does not overshoot


def table_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield the tables whose cubic splines leave the range of their values."""
    candidates = chain(_of_time(run.mechanism), _of_curves(run.mechanism))
    for key, share, others in candidates:
        if share > TABLE_OVERSHOOTS.limit:
            text = (
                f"{key}: the cubic spline goes beyond the values of the table by {share:.0%} of "
                f"their range (expected at most {TABLE_OVERSHOOTS.limit:.0%}). {others}"
            )
            yield TABLE_OVERSHOOTS.finding(text, value=share)


def _of_time(mechanism: "Mechanism") -> Iterator[Beyond]:
    remedy = 'interpolation = "pchip" does not; more points, or smooth_step, make it smaller'
    for name, joint in mechanism.joints.items():
        for key, drive in drives(joint).items():
            if drive.table is not None:
                yield f"joints.{name}.{key}.table", _share(drive.table), remedy
    remedy = 'interpolation = "linear" and "pchip" do not'
    for name, force in mechanism.forces.items():
        load = law(force)
        if load is not None and load.table is not None:
            key = "law" if is_load(force) else "actuator"
            yield f"forces.{name}.{key}.table", _share(load.table), remedy


def _share(table: "laws_of_case.DriveTable | laws_of_case.LoadTable") -> float:
    if table.interpolation != "spline":
        return 0.0  # such curves stay within the values
    times, values = column(table.times), column(table.values)
    return laws.overshoot(laws.table(times, values, table.interpolation), values)


def _of_curves(mechanism: "Mechanism") -> Iterator[Beyond]:
    remedy = 'interpolation = "linear" does not'
    for name, force in mechanism.forces.items():
        if not is_along(force):
            continue
        for key in ("force_displacement", "force_velocity"):
            given = getattr(force, key, None)
            if given is not None:
                through = laws.curve(given.x, given.y, smooth=given.interpolation == "spline")
                yield f"forces.{name}.{key}", laws.overshoot(through, given.y, 1), remedy
    remedy = 'interpolation = "pchip" and "linear" do not'
    for name, points in mechanism.tables.items():
        if points.interpolation != "cubic":
            continue
        x, y = column(points.x), column(points.y)
        through = laws.curve_of_table(x, y, points.interpolation, points.extrapolation)
        yield f"tables.{name}", laws.overshoot(through, y, 1), remedy
