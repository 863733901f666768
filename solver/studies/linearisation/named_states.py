"""Linearised equations in states that have names: displacements of independent coordinates."""

from typing import NamedTuple

import numpy as np
from scipy.linalg import qr

from ...math.arrays import Array
from .state_space import StateSpace


class Realisation(NamedTuple):
    """x' = A x + B u, y = C x + D u with named states, inputs and outputs, in SI units."""

    A: Array  # (n, n)
    B: Array  # (n, n_in)
    C: Array  # (n_out, n)
    D: Array  # (n_out, n_in)
    states: list[str]
    inputs: list[str]
    input_units: list[str]
    outputs: list[str]
    output_units: list[str]


def realisation(space: StateSpace, coordinates: list[str], auxiliary: list[str]) -> Realisation:
    """Return the equations in the displacements of independent coordinates and their rates.

    Parameters
    ----------
    coordinates : (n_vel,) names of the velocity coordinates
    auxiliary : (n_aux,) names of the auxiliary states

    The coordinates are chosen by a QR decomposition with pivoting of the free motions. A rate is
    the velocity beside that which the constraints ask of the displaced state (zeta of
    state_space.py); where the state is at rest it is the rate of the coordinate.
    """
    Z, n = space.free.Z, space.n_free
    root = np.sqrt(space.inertia_scale)[:, None]
    order: Array = qr((root * Z).T, pivoting=True, mode="r")[1] if n else np.zeros(0)
    chosen = sorted(int(k) for k in order[:n])
    S = np.eye(len(space.A))
    S[:n, :n] = S[n : 2 * n, n : 2 * n] = Z[chosen]
    inverse = np.linalg.inv(S)
    drives = [s.name for s in space.inputs if s.drive]
    others = [auxiliary[j] for j in space.auxiliary]
    return Realisation(
        A=S @ space.A @ inverse,
        B=S @ space.B,
        C=space.C @ inverse,
        D=space.D,
        states=[
            *(coordinates[k] for k in chosen),
            *(f"rate of {coordinates[k]}" for k in chosen),
            *others,
            *drives,
            *(f"rate of {name}" for name in drives),
        ],
        inputs=[s.name for s in space.inputs],
        input_units=[s.unit for s in space.inputs],
        outputs=[name for name, _ in space.outputs],
        output_units=[unit for _, unit in space.outputs],
    )
