"""Baumgarte stabilisation: feedback of position and velocity violations. Paper: Eq. (13)."""

from ....math.arrays import Array


def stabilised(gamma: Array, Phi: Array, Phi_d: Array, alpha: float, beta: float) -> Array:
    """Return gamma = gamma* - 2 alpha Phidot - beta^2 Phi, (n,). Paper: Eq. (13).

    For alpha = beta a violation decays with critical damping and the time
    constant 1/alpha. Explicit steps require beta h below about 2.

    Parameters
    ----------
    gamma : right-hand sides without feedback (n,)
    Phi : constraint violations (n,)
    Phi_d : their rates (n,)
    alpha : feedback of the rates [1/s]
    beta : feedback of the violations [1/s]
    """
    return gamma - 2.0 * alpha * Phi_d - beta * beta * Phi
