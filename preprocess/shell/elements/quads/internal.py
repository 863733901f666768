"""Internal rotations of a quadrilateral that is narrow compared with its thickness.

In torsion of a narrow strip the rotation along the strip is a hyperbolic sine across its width, and
bilinear rotations of one cell are too stiff by up to 13 %. Each cell therefore has two rotations of
its own, of cubic shape f(s) = s^3 - s, zero on the sides that they run along:

    b = c_1 t_1 f(eta) + c_2 t_2 f(xi),

with unit vectors t_1, t_2 along xi and eta at the centre. The mean of their curvature and of their
shear strain is zero (both are taken with the derivatives of the centre), so every constant state
is kept; they only answer to a shear strain along one direction that varies across it. Integrals
over a square of side 2: int f'^2 = 16/5, int f^2 = 32/105, and int f g = -(2/5) int s g for g
linear in s. The curvature of the corners' motion does no work on f'. All other products of the two
vanish, so each is eliminated alone.
"""

from typing import Any

from ufl import as_vector, dot, inv, sqrt

from ...mesh.quadrilaterals import GAUSS
from ..cell import Cell

CURVED, SHEARED, ANSWER = 16.0 / 5.0, 32.0 / 105.0, -2.0 / 5.0


def relief(q: Cell, shear: list[Any]) -> list[tuple[Any, Any]]:
    """Stiffness that the internal rotations take from the plate: negative pairs.

    Parameters
    ----------
    shear : shear strain at the points of the cell
    """
    D = q.D - q.B * inv(q.A) * q.B  # with free membrane resultants
    at, pairs = q.mapping, []
    for along, gradient, across in ((at.by_xi, at.grad_eta, 1), (at.by_eta, at.grad_xi, 0)):
        t = along / sqrt(dot(along, along))
        k = as_vector(
            (t[0] * gradient[0], t[1] * gradient[1], t[0] * gradient[1] + t[1] * gradient[0])
        )
        own = CURVED * dot(k, D * k) + SHEARED * dot(t, q.Ds * t)
        places = GAUSS[:, across].tolist()
        work = sum(s * dot(q.Ds * t, gamma) for s, gamma in zip(places, shear, strict=True))
        answer = as_vector([ANSWER * work])
        pairs.append((-abs(at.det) / own * answer, answer))
    return pairs
