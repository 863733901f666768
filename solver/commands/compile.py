"""Compile the step loop before the first run, so that runs in parallel need not each do it."""

import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from ..dynamics.bodies.floating_frame import centrifugal_matrix
from ..dynamics.bodies.marker import single_motion
from ..dynamics.coordinates import moved, position_rates
from ..dynamics.forces.table import KINDS as FORCE_KINDS
from ..dynamics.forces.table import element_wrench
from ..dynamics.joints.table import KINDS
from ..dynamics.model import Model
from ..dynamics.projection import projected
from ..dynamics.system import assemble, derivative, energies, law_at
from ..dynamics.tables import ForceTable, JointTable, MarkerTable, assemble_model, rigid_body
from ..integrators.closures import right_hand_side
from ..integrators.generic import RungeKutta8, integrate
from ..integrators.stepping import GeneralizedAlpha, Radau, StepLoop
from ..math.arrays import Array
from ..math.compiled import COMPILED
from ..math.laws import polynomial
from ..math.rotations import rotation_matrix, vector_to_matrix


def compile_ahead() -> str:
    """Call every compiled function once; return what was done, in words.

    What all share comes first; then the loops, in two processes.
    """
    if not COMPILED:
        return "Numba is not used: runs take plain NumPy"
    begin = time.perf_counter()
    _compile_shared()
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        for done in [pool.submit(part) for part in (_compile_radau, _compile_others)]:
            done.result()
    return f"step loop ready in {time.perf_counter() - begin:.1f} s"


def _hinge() -> tuple[Model, Array]:
    """A body on a hinge, and its state."""
    body = rigid_body("body", 1.0, np.zeros(3), np.eye(3))
    markers = [MarkerTable(-1, np.zeros(3)), MarkerTable(0, np.zeros(3))]
    model = assemble_model([body], markers, [JointTable("hinge", "revolute", 0, 1)])
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[3] = 1.0
    return model, y


def _compile_radau() -> None:
    _step_loop(Radau)


def _compile_others() -> None:
    model, y = _hinge()
    RungeKutta8(right_hand_side(model), 0.0, y, 1e-3, first_step=1e-3).step()
    _step_loop(GeneralizedAlpha)


def _step_loop(kind: type[StepLoop]) -> None:
    """Take one step, then several in one call."""
    model, y = _hinge()
    one = kind(model, 0.0, y, 1e-3, first_step=1e-3)
    one.step()
    one.dense_output()(5e-4)
    integrate(kind(model, 0.0, y, 1e-3, first_step=1e-3), [0.0, 5e-4, 1e-3])


def _compile_shared() -> None:
    """Evaluation, accelerations, projection, and what is called outside of the loops."""
    body = rigid_body("body", 1.0, np.zeros(3), np.eye(3))
    markers = [MarkerTable(-1, np.zeros(3)), MarkerTable(0, np.zeros(3))]
    law = polynomial([0.0])
    joints = [JointTable(kind, kind, 0, 1, law, 1.0) for kind in KINDS]
    forces = [ForceTable(kind, kind, 0, 1, law=law) for kind in FORCE_KINDS]
    model = assemble_model([body], markers, joints, [(1, 1.0)], alpha=0.0, forces=forces)
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[3] = 1.0
    equations = assemble(model, 0.0, y)
    free = assemble_model([body], markers, [], [(1, 1.0)])
    alone = assemble(free, 0.0, y)
    derivative(free, 0.0, y)
    energies(free, alone, y)
    hinge, still = _hinge()
    projected(hinge, 0.0, still)
    position_rates(free, y[:7], y[7:13])
    moved(free, y[:7], y[7:13])
    marker, _ = single_motion(model, 1, y)
    element_wrench(0, marker, marker, model.force_parameters[0], 0.0)
    rotation_matrix(y[3:7])
    vector_to_matrix(equations.gamma[:3])
    law_at(model, 0, 0.0)
    centrifugal_matrix(y[10:13], np.zeros(9), 1)
