"""Stages of an explicit Runge-Kutta step, all in one call."""

from ...dynamics.model import Model
from ...dynamics.system import derivative_into
from ...dynamics.workspace import Work
from ...math.arrays import Array
from ...math.compiled import lean


@lean
def fill_stages(
    model: Model,
    work: Work,
    A: Array,
    C: Array,
    t: float,
    y: Array,
    h: float,
    K: Array,
    point: Array,
) -> None:
    """Fill K[1:s] (s, n) with the derivatives at the stages of a step h from (t, y); K[0] is there.

    Parameters
    ----------
    A, C : (s, s), (s,) of the tableau
    point : (n,) memory; holds the last stage's state at the end
    """
    n = y.shape[0]
    for i in range(1, C.shape[0]):
        for k in range(n):
            point[k] = A[i, 0] * K[0, k]
        for j in range(1, i):
            a = A[i, j]
            if a != 0.0:
                for k in range(n):
                    point[k] += a * K[j, k]
        for k in range(n):
            point[k] = y[k] + h * point[k]
        derivative_into(model, work, t + C[i] * h, point, K[i])
