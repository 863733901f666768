"""Compile the step loop before the first run, so that runs in parallel need not each do it."""

import time

import numpy as np

from .assemble import ForceTable, JointTable, MarkerTable, assemble_model, rigid_body
from .bodies.floating_frame import centrifugal_matrix
from .bodies.marker import single_motion
from .closures import right_hand_side
from .compiled import COMPILED
from .coordinates import moved, position_rates
from .forces.table import KINDS as FORCE_KINDS
from .forces.table import element_wrench
from .integrate import RungeKutta8, integrate
from .joints.table import KINDS
from .laws import polynomial
from .marching import CompiledAlpha, Radau
from .projection import projected
from .rotations import rotation_matrix, vector_to_matrix
from .system import assemble, derivative, energies, law_at


def compile_ahead() -> str:
    """Call every compiled function once; return what was done, in words."""
    if not COMPILED:
        return "Numba is not used: runs take plain NumPy"
    begin = time.perf_counter()
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
    hinge = assemble_model([body], markers, [JointTable("hinge", "revolute", 0, 1)])
    projected(hinge, 0.0, y)
    position_rates(free, y[:7], y[7:13])
    moved(free, y[:7], y[7:13])
    marker, _ = single_motion(model, 1, y)
    element_wrench(0, marker, marker, model.force_parameters[0], 0.0)
    rotation_matrix(y[3:7])
    vector_to_matrix(equations.gamma[:3])
    law_at(model, 0, 0.0)
    centrifugal_matrix(y[10:13], np.zeros(9), 1)
    RungeKutta8(right_hand_side(hinge), 0.0, y, 1e-3, first_step=1e-3).step()
    for kind in (Radau, CompiledAlpha):
        march = kind(hinge, 0.0, y, 1e-3, first_step=1e-3)
        march.step()
        march.dense_output()(5e-4)
        integrate(kind(hinge, 0.0, y, 1e-3, first_step=1e-3), [0.0, 5e-4, 1e-3])
    return f"step loop ready in {time.perf_counter() - begin:.1f} s"
