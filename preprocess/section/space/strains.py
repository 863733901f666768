"""Strains of a section as UFL text: of a warping w with the gradient d in the section.

Strains are (11, 22, 33, 23, 13, 12), with the shear strains of engineering; d[a, alpha] is the
derivative of component a + 1 by x2 (alpha = 0) or x3 (alpha = 1). A displacement w(x1, x2, x3) of
the points of a section has the strain G_h w + G_l w', with ' for d/dx1. DOLFINx evaluates w and d
of all unknowns at the points (space.py).

The reference line of a twisted and curved beam has the constant twist k1 and curvatures k2, k3:
b_i' = k x b_i for the axes b_i of the section. The strain is then G_k w + G_l (w' + Z e) / g, where
the columns of Z are the rigid motions of the section, e are the strains of the beam, and g dA dx1
is the volume.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from ufl import as_matrix, as_vector, cross

from ....solver.math.arrays import Array


def strain_in_section(_w: Any, d: Any) -> Any:
    """G_h w: strain of a warping that does not change along the beam. Paper: Eq. (37)."""
    return as_vector([0, d[1, 0], d[2, 1], d[1, 1] + d[2, 0], d[0, 1], d[0, 0]])


def strain_along_beam(w: Any, _d: Any = None) -> Any:
    """G_l w: strain of a change w of the warping per x1. Paper: Eq. (38)."""
    return as_vector([w[0], 0, 0, 0, w[2], w[1]])


def volume(k: Any, x: Any) -> Any:
    """Volume g per area of the section and length of the reference line, at x = (x2, x3)."""
    return 1 - x[0] * k[2] + x[1] * k[1]


def twisted_strain_in_section(w: Any, d: Any, k: Any, x: Any) -> Any:
    """G_k w = G_h w + G_l (k x w + k1 (x3 w,2 - x2 w,3)) / g.

    Parameters
    ----------
    w, d : warping (3,) and its gradient (3, 2)
    k : (3,) twist and curvature [rad/m]
    x : x2, x3 [m]
    """
    turning = cross(k, w) + k[0] * as_vector([x[1] * d[a, 0] - x[0] * d[a, 1] for a in range(3)])
    return strain_in_section(w, d) + strain_along_beam(turning) / volume(k, x)


@cache
def fixed(strain: Callable[[Any, Any], Any]) -> Array:
    """`coefficients` (6, 9) that are numbers."""
    S = coefficients(strain)
    return np.array([[float(S[row, column]) for column in range(9)] for row in range(6)])


def coefficients(strain: Callable[[Any, Any], Any]) -> Any:
    """S (6, 9) of a strain S (w, w,2, w,3), which is linear in the warping and its gradient."""
    columns = []
    for unit in np.eye(9).reshape(9, 3, 3):  # of w, w,2 or w,3, a component
        columns.append(strain(as_vector(unit[0].tolist()), as_matrix(unit[1:].T.tolist())))
    return as_matrix([[column[row] for column in columns] for row in range(6)])
