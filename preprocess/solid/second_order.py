"""Work of the second-order strains of pairs of modes on the stresses of a solid."""

import numpy as np
import ufl

from ...solver.math.arrays import Array
from ..modes.reduced import pairs
from .forms import strain
from .model import SolidModel


def second_order_forces(model: SolidModel, U: Array) -> Array:
    """Forces g of each pair of modes i <= j, (3 n, pairs): see exchange/inertia.py.

    Parameters
    ----------
    U : (3 n, m) displacements of the nodes in the modes
    """
    space = model.space
    v, one, other = ufl.TestFunction(space.space), space.field(), space.field()
    product = ufl.sym(ufl.grad(one).T * ufl.grad(other))
    vector = space.vectors(model.elasticity(space).work(strain(v), product))
    found = np.empty((len(U), len(pairs(U.shape[1])[0])))
    for k, (i, j) in enumerate(zip(*pairs(U.shape[1]), strict=True)):
        space.fill(one, U[:, i].reshape(-1, 3))
        space.fill(other, U[:, j].reshape(-1, 3))
        found[:, k] = vector()
    return found
