"""What is seen of every accepted step: energies, the certificate of the constraints, spins."""

from typing import NamedTuple

import numpy as np

from ...dynamics.analysis.independence import Independence, certificate, new_independence
from ...dynamics.evaluation.energy import energies_into
from ...dynamics.evaluation.evaluation import evaluate
from ...dynamics.model.model import Model
from ...dynamics.model.workspace import Work, new_work
from ...math.arrays import Array, IntArray
from ...math.compiled import inlined, lean, structure

LOW, HIGH = 0, 1  # entries of `limits`


@structure
class Observation(NamedTuple):
    """Memory of a run that is watched."""

    work: Work
    rows: Independence
    energy: Array  # (k, 3) kinetic, strain, potential, at ends of steps noted one by one [J]
    pivots: Array  # (k,) of their certificates
    noted: IntArray  # (1,) how many they are
    limits: Array  # (2,) pivots between which a step needs no look
    safe: Array  # (nb,) square of the spin below which it needs none [rad2/s2]
    regular: Array  # (1,) pivot of every step of a mechanism without loops; 0: to be found


def new_observation(model: Model, most: int) -> Observation:
    """Return memory for a model, and `most` steps noted one by one; spins need no look."""
    return Observation(
        new_work(model),
        new_independence(model),
        np.zeros((most, 3)),
        np.zeros(most),
        np.zeros(1, dtype=np.int64),
        np.array([-np.inf, np.inf]),
        np.full(model.n_body, np.inf),
        np.zeros(1),
    )


@lean
def observe(
    model: Model, seen: Observation, t: Array, y: Array, energy: Array, pivots: Array
) -> None:
    """Fill energy (k, 3) and pivots (k,) of steps that end at t (k,), y (k, n)."""
    for s in range(t.shape[0]):
        pivots[s] = _observe(model, seen, t[s], y[s], energy[s])


@lean
def note(model: Model, seen: Observation, t: float, y: Array) -> bool:
    """Keep energy and pivot of the next step, which ends at t, y (n,); tell if it needs a look."""
    k = seen.noted[0]
    pivot = _observe(model, seen, t, y, seen.energy[k])
    seen.pivots[k] = pivot
    seen.noted[0] = k + 1
    doubt = not (pivot > seen.limits[LOW] and pivot < seen.limits[HIGH])
    for i in range(model.n_body):
        j = model.n_pos + model.vel_start[i] + 3
        spin = y[j] * y[j] + y[j + 1] * y[j + 1] + y[j + 2] * y[j + 2]
        doubt = doubt or spin >= seen.safe[i]
    return doubt


@inlined
def _observe(model: Model, seen: Observation, t: float, y: Array, energy: Array) -> float:
    evaluate(model, seen.work, t, y)
    energies_into(model, seen.work, y, energy)
    if seen.regular[0] > 0.0:
        return seen.regular[0]
    return certificate(model, seen.work, seen.rows, t, y)
