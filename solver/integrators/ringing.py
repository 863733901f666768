"""Which vibration keeps the steps of Radau IIA short, and how much of the motion it is."""

import numpy as np

from ..dynamics.evaluation import evaluate
from ..dynamics.model import Model
from ..dynamics.workspace import new_work
from ..math.arrays import Array
from .compiled.cutoff import filter_error, new_cutoff, start_filter
from .compiled.pencil import freeze, new_frozen
from .compiled.radau_workspace import RadauWorkspace


def ringing(model: Model, workspace: RadauWorkspace) -> tuple[int, float]:
    """Return the component of the state that rings most in the last step, and its rate [rad/s].

    By the cubic coefficients of the step's polynomials: of a vibration that the step resolves,
    those of velocities are w times those of positions. Components are weighed by inertia.
    """
    cubic, n_pos, M = workspace.Q[2], model.n_pos, workspace.frozen.M
    size = np.zeros(model.n_vel)
    for i, j in enumerate(model.vel_start):
        for k in range(int(model.plan.size[i])):
            size[j + k] = M[i, k, k] * cubic[n_pos + j + k] ** 2
    most = int(np.argmax(size))
    i = int(np.searchsorted(model.vel_start, most, side="right")) - 1
    k, a = most - int(model.vel_start[i]), int(model.pos_start[i])
    turns, j = 3 <= k < 6, n_pos + most
    q = a + k + (1 if k > 5 else 0)
    swing = 2.0 * cubic[a + 3 : a + 7] if turns else cubic[q : q + 1]
    speed = cubic[j - k + 3 : j - k + 6] if turns else cubic[j : j + 1]
    size_q, size_v = float(np.linalg.norm(swing)), float(np.linalg.norm(speed))
    return j, size_v / size_q if size_q > 0.0 else 0.0


def kinetic_energies(
    model: Model, least: Array, t: float, y: Array, cutoff: float
) -> tuple[float, float]:
    """Return the kinetic energy of vibrations above a cutoff [rad/s], and of all motion [J].

    In state y (n,) at t [s], by the filter that takes such vibrations out of errors: motion without
    stiffness is not among them, however fast it is. `least` (n_e,): as of `new_cutoff`.
    """
    work, frozen = new_work(model), new_frozen(model)
    evaluate(model, work, t, y)
    freeze(model, work, t, y, frozen)
    memory = new_cutoff(model, frozen, least.copy())
    start_filter(model, frozen, memory, cutoff)
    filter_error(model, memory, cutoff, y)
    found = np.zeros(2)
    for i, j in enumerate(np.asarray(model.vel_start) + model.n_pos):
        size, lead = int(model.plan.size[i]), int(model.plan.lead[i])
        M = frozen.M[i, :size, :size]
        lower = np.tril(M, -1)
        lower[:, lead:] = 0.0
        v = y[j : j + size]
        for k, w in enumerate((v - memory.error[j : j + size], v)):
            found[k] += w @ lower @ w + 0.5 * (np.diag(M) * w) @ w
    return float(found[0]), float(found[1])
