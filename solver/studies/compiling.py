"""Compile the step loop before the first run, so that runs in parallel need not each do it."""

import time
from collections.abc import Callable
from functools import partial

import numpy as np

from ..checks.singularity import SingularityMonitor
from ..dynamics.analysis.projection import least_energy, projected
from ..dynamics.analysis.rank import difference, new_independence, new_spectrum
from ..dynamics.elements.forces.table import KINDS as FORCE_KINDS
from ..dynamics.elements.joints.table import KINDS, N_PARAMETER
from ..dynamics.elements.marker import single_motion
from ..dynamics.evaluation import series
from ..dynamics.evaluation.accelerations import (
    assemble,
    derivative,
    energies,
    masses_and_jacobians,
)
from ..dynamics.evaluation.evaluation import measure_into
from ..dynamics.evaluation.laws import law_at
from ..dynamics.evaluation.reactions import reads_reactions
from ..dynamics.evaluation.variations import along_directions, residuals
from ..dynamics.model.coordinates import move_rows, moved, position_rates
from ..dynamics.model.model import Model, spare_workspace, state_size
from ..inputs.case.record import solver_sha256
from ..integrators.compiled.pencil import factorise_pencil, new_frozen, new_pencil, solve_pencil
from ..integrators.explicit import RungeKutta8, RungeKutta8Loop
from ..integrators.expression_breaks import bend, first_break, first_hidden, watched_expression
from ..integrators.generalized_alpha import GeneralizedAlpha
from ..integrators.generic.drive import integrate
from ..integrators.radau import Radau
from ..integrators.step_loop import StepLoop, right_hand_side
from ..math.arrays import Array
from ..math.compiled import COMPILED, note, noted, statistics
from ..math.expressions import operations as op
from ..math.expressions.program import ONE, Node, programs, value_at
from ..math.expressions.ranges import parts
from ..math.laws import polynomial
from ..math.rotations import rotation_matrices, rotation_matrix, vectors_to_matrices
from ..mechanism.assembly import assemble_model
from ..mechanism.tables import ForceTable, JointTable, MarkerTable, rigid_body
from ..signals.points import rotation_vectors
from ..workers.executors import Local


def compile_ahead(*, everything: bool = False) -> str:
    """Call every function that runs of `radau` and the explicit methods need; say what was done.

    In two processes, which share what they have compiled by way of the cache. `everything`:
    generalized-alpha as well.
    """
    if not COMPILED:
        return "Numba is not used: runs take plain NumPy"
    begin = time.perf_counter()
    rounds: list[tuple[Callable[[], None], ...]] = [
        (_compile_evaluation, _compile_matrices),
        (partial(_step_loop, Radau), _compile_others),
    ]
    if everything:
        rounds.append((partial(_step_loop, GeneralizedAlpha),))
    made, kept = 0, True
    workers, complete = Local(2), False
    try:
        for parts in rounds:
            for done in [workers.submit(k, _statistics_of, part) for k, part in enumerate(parts)]:
                count, can_be_kept = done.result()
                made, kept = made + count, kept and can_be_kept
        complete = True
    finally:
        workers.close(at_once=not complete)
    text = f"step loop ready in {time.perf_counter() - begin:.1f} s, {made} functions compiled"
    if kept:
        note("compiled ahead", solver_sha256())
    return text if kept else f"{text}; no folder for them can be written: not kept"


def compile_once() -> None:
    """Call `compile_ahead` unless it was called before, with these sources and this Numba."""
    if COMPILED and not noted("compiled ahead", solver_sha256()):
        compile_ahead()


def _statistics_of(part: Callable[[], None]) -> tuple[int, bool]:
    """Do one part; return how many functions it has compiled, and whether they can be kept."""
    before = len(statistics.compiled)
    part()
    return len(statistics.compiled) - before, statistics.kept


def _hinge() -> tuple[Model, Array]:
    """A body on a hinge, and its state."""
    body = rigid_body("body", 1.0, np.zeros(3), np.eye(3))
    markers = [MarkerTable(-1, np.zeros(3)), MarkerTable(0, np.zeros(3))]
    model = assemble_model([body], markers, [JointTable("hinge", "revolute", 0, 1)])
    y = np.zeros(state_size(model))
    y[3] = 1.0
    return model, y


def _compile_matrices() -> None:
    """Newton's matrices, real and complex, and their solution; tangents of runs."""
    model, y = _hinge()
    frozen = new_frozen(model)
    frozen.M[:], frozen.J[:] = np.eye(6), 1.0
    for one in (1.0, 1.0 + 0.0j):
        pencil = new_pencil(model, one)
        factorise_pencil(model, frozen, pencil, one, one, 1.0)
        solve_pencil(model, frozen, pencil, one)
    t, states, zero = np.zeros(1), y[None], np.zeros((1, model.n_vel))
    ways = np.zeros((1, 1, 2 * model.n_vel + model.n_aux))
    along = t, states, zero, np.zeros((1, model.n_constraint)), ways, np.ones((1, 1))
    residuals(model, *along[:4])
    along_directions(model, *along)
    masses_and_jacobians(model, t, states)
    move_rows(model, states, zero)


def _step_loop(kind: type[StepLoop]) -> None:
    """Take one step, then several in one call."""
    model, y = _hinge()
    one = kind(model, 0.0, y, 1e-3, first_step=1e-3)
    one.step()
    one.dense_output()(5e-4)
    integrate(kind(model, 0.0, y, 1e-3, first_step=1e-3), [0.0, 5e-4, 1e-3])


def _compile_others() -> None:
    """Accelerations, projection, explicit methods, monitors, and calls outside of the loops."""
    model, y = _hinge()
    projected(model, 0.0, y)
    reads_reactions(model)
    measure_into(model, spare_workspace(model), y)
    _step_loop(RungeKutta8Loop)
    for made in (
        RungeKutta8Loop(model, 0.0, y, 1e-3),
        RungeKutta8(right_hand_side(model), 0.0, y, 1e-3),
    ):
        passage = SingularityMonitor(model, ["hinge"], "projection")
        passage.at_start(0.0, y)
        integrate(made, [0.0, 1e-3], watch=passage)
        passage.explain(1e-3, y)
    rows = new_independence(model)
    difference(model, new_spectrum(rows), rows.C, rows.C)
    least_energy(model, 0.0, y, np.zeros(1, dtype=np.int64), np.zeros(1))
    derivative(model, 0.0, y)
    series.along_solution(model, np.zeros(1), y[None])
    position_rates(model, y[:7], y[7:13])
    moved(model, y[:7], y[7:13])
    single_motion(model, 1, y)
    series.marker_motions(model, 1, y[None])
    series.marker_places(model, y)
    rotation_matrix(y[3:7])
    rotation_vectors(rotation_matrices(y[None, 3:7]))
    vectors_to_matrices(y[None, 7:10])
    law_at(model, -1, 0.0)
    value_at(ONE)
    read = Node(op.ABS, (Node(op.LOAD),))
    of_one = model.quantities._replace(programs=programs([read], lambda _: 0))
    watched = watched_expression(
        model._replace(quantities=of_one), 0, np.zeros(1), np.zeros((2, 1, 2))
    )
    if watched is not None:
        first_hidden(watched, np.zeros(1), np.zeros((1, 1)), 0.0, 0.0)
        first_break(watched, np.zeros(1), np.zeros((1, 1)), 0, 0.0, 0.0)
        bend(watched, np.zeros(5), np.zeros((5, 1)))
    parts(of_one.programs, 0, np.zeros(1), np.zeros(1), of_one.stack)


def _compile_evaluation() -> None:
    """All kinds of joints and force elements."""
    body = rigid_body("body", 1.0, np.zeros(3), np.eye(3))
    markers = [MarkerTable(-1, np.zeros(3)), MarkerTable(0, np.zeros(3))]
    law = polynomial([0.0])
    joints = [JointTable(kind, kind, 0, 1, law, (1.0,) * N_PARAMETER) for kind in KINDS]
    forces = [ForceTable(kind, kind, 0, 1, law=law) for kind in FORCE_KINDS]
    model = assemble_model([body], markers, joints, [(1, 1.0)], alpha=0.0, forces=forces)
    y = np.zeros(state_size(model))
    y[3] = 1.0
    t, states = np.zeros(1), y[None]
    energies(model, assemble(model, 0.0, y), y)
    series.balance(model, t, states)
    series.momenta(model, states)
    series.quantities(model, t, states)
    series.marker_loads(model, t, states, np.zeros((1, model.n_constraint)))
    series.force_sizes(model, 0, t, states, np.zeros((1, model.n_constraint)))
    series.mass_matrices(model, 0, t, states)
    series.driven_speeds(model, t, states[0])
