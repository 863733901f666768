"""Linearised equations by complex steps: exact derivatives, in plain NumPy only.

Run as a program with PLYMOTION_COMPILED=0: prints the largest differences from `linearise`.
    python tests/peers/complex_steps.py CASE PACKAGES RUN AT
"""

import json
import sys
from pathlib import Path

import numpy as np

from plymotion.solver.dynamics.evaluation.evaluation import evaluate
from plymotion.solver.dynamics.model.coordinates import position_rates
from plymotion.solver.dynamics.model.model import GAMMA, PHI_T, Model, new_workspace
from plymotion.solver.studies.linearisation.state_space import linearise, turning_axes
from plymotion.solver.studies.modes.place import at_of
from plymotion.solver.studies.modes.state import States, read_spec

STEP = 1e-30


def complex_work(work):
    """The same memory for complex numbers."""
    found = {}
    for name in work._fields:
        value = getattr(work, name)
        if hasattr(value, "_fields"):
            found[name] = complex_work(value)
        elif isinstance(value, np.ndarray) and value.dtype == float:
            found[name] = value.astype(complex)
    return work._replace(**found)


def accelerations_and_rates(model: Model, t: float, y: np.ndarray):
    """Accelerations (n_vel,) and Phidot (n_c,) in a complex state, constraints independent."""
    work = complex_work(new_workspace(model))
    evaluate(model, work, t, y)
    n, n_c = model.n_vel, model.n_constraint
    K, f = np.zeros((n + n_c, n + n_c), dtype=complex), np.zeros(n + n_c, dtype=complex)
    for i in range(model.n_body):
        j, size = int(model.vel_start[i]), int(model.layout.size[i])
        M = np.tril(work.M[i, :size, :size])
        K[j : j + size, j : j + size] = M + np.tril(M, -1).T
        f[j : j + size] = work.f[i, :size]
    for k in range(len(model.joint_kind)):
        rows = np.arange(model.joint_row[k], model.joint_row[k + 1])
        for side in range(2):
            body = int(model.marker_body[model.joint_marker[k, side]])
            if body >= 0:
                j, size = int(model.vel_start[body]), int(model.layout.size[body])
                first = int(model.layout.side_row[k, side])
                J = work.J[body, :size, first : first + len(rows)]
                K[n + rows[:, None], np.arange(j, j + size)] += J.T
    K[:n, n:] = K[n:, :n].T
    f[n:] = work.rows[:, GAMMA]
    v = y[model.n_pos : model.n_pos + n]
    return np.linalg.solve(K, f)[:n], K[n:, :n] @ v + work.rows[:, PHI_T]


def compare(case: str, packages: str, run: str, at: str) -> dict:
    """Largest differences of both blocks of A, over the largest entry of their columns."""
    spec, _ = read_spec(Path(case), run, packages=Path(packages), coarse=False)
    state = States(spec).at(at_of(at), None)
    W = state.spin.W if state.spin is not None else np.zeros(3)
    space = linearise(state.model, state.t, state.y, W)
    model, t, y = state.model, state.t, space.y

    def slopes(x, u):
        step = np.concatenate([position_rates(model, y[: model.n_pos], x), u, [0.0]])
        a, rate = accelerations_and_rates(model, t, y + 1j * STEP * step)
        return a.imag / STEP, rate.imag / STEP

    free, n = space.free, space.n_free
    none = np.zeros(model.n_vel)
    B = -free.P @ np.array([slopes(x, none)[1] for x in free.Z.T]).T
    da = [slopes(x, u)[0] for x, u in zip(free.Z.T, B.T, strict=True)]
    da += [slopes(none, u)[0] for u in free.Z.T]
    frame, both = turning_axes(model, y, W), np.hstack([B, free.Z])
    beside = np.eye(model.n_vel) - free.Z @ free.Z_left
    change = (beside @ (B + frame.T @ free.Z)).T @ np.diag(model.inertia_scale)
    expected = free.Z_left @ (np.array(da).T + frame.T_u @ both) + change @ beside @ both
    off = np.abs(space.A_free[n:] - expected) / np.abs(expected).max(axis=0).clip(min=1.0)
    return {
        "accelerations": float(off.max()),
        "velocities": float(np.abs(space.velocity - B).max()),
    }


if __name__ == "__main__":
    print(json.dumps(compare(*sys.argv[1:])))
