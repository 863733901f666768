"""Derivatives of packages by differences of rebuilt ones, free of the basis of their modes.

A fresh package has modes of other signs, and in a cluster of other directions. Each modal axis of
its datasets is therefore contracted with the modal responses V to unit loads at the interfaces, and
with K^-1 M V. What is left depends on the span of the modes only.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from plymotion.preprocess.design import ANGLE_DEG, RELATIVE
from plymotion.preprocess.parameters import Parameter
from plymotion.solver.package import ModalPackage
from plymotion.solver.package.common.dataset import all_values, shapes_by_path
from plymotion.solver.package.common.design import moved

SIX = ((-3, -1), (-2, 9), (-1, -45), (1, 45), (2, -9), (3, 1))  # places and weights, by 60 h
# of the modes themselves; an indicator without derivative
LEFT_OUT = ("frequencies", "end_compliance")


def invariant(package: ModalPackage, size: float, stiff: float) -> dict[str, np.ndarray]:
    """All numbers of a package without its basis, by path.

    Responses are divided by `size`, those of K^-1 M V multiplied by the eigenvalue `stiff`.
    """
    K, M = package.stiffness, package.mass
    loads = np.vstack([part for i in package.interfaces for part in (i.phi_B, i.psi_B)])
    first = np.linalg.solve(K, loads.T)
    V = np.hstack([first, np.linalg.solve(K, M @ first) * stiff]) / size
    shapes, found = shapes_by_path(package), {}
    for path, value in all_values(package).items():
        array = np.asarray(value)
        if array.dtype.kind != "f" or path.rpartition("/")[2] in LEFT_OUT:
            continue
        for axis, symbol in enumerate(shapes[path].split(", ")):
            if symbol == "m":
                array = np.moveaxis(np.tensordot(array, V, (axis, 0)), -1, axis)
        found[path] = array
    return found


def errors(
    package: ModalPackage,
    parameter: Parameter,
    rebuilt: Callable[[float], ModalPackage],
    steps: float = 10.0,
) -> dict[str, float]:
    """Error of the derivatives of each dataset, relative to its size in the parameter's unit.

    `rebuilt` is the package with the parameter moved by a distance, multiples of `steps` times the
    step of the parameter. The unit is that of a change
    by as much as the value, of a radian for an angle.
    """
    V = np.linalg.solve(package.stiffness, np.vstack([i.phi_B for i in package.interfaces]).T)
    size = float(np.abs(V).max()), float(package.stiffness[0, 0])
    h = steps * parameter.step
    unit = parameter.step / RELATIVE
    if parameter.targets[0].kind == "angle":
        unit = parameter.step / np.deg2rad(ANGLE_DEG)
    now = invariant(package, *size)
    at = [(weight, invariant(rebuilt(place * h), *size)) for place, weight in SIX]
    alone = replace(package, design=tuple(d for d in package.design if d.name == parameter.name))
    near = [
        (w, invariant(moved(alone, {parameter.name: place * 1e-3 * h}), *size)) for place, w in SIX
    ]
    # sums that may cancel, by the size of their terms: as `second_order_sizes`
    mass, reach = package.invariants.mass, np.abs(package.nodes_B).max()
    shape, turn = (
        np.abs(now["modes/shapes_B"][..., part]).max() for part in (np.s_[:3], np.s_[3:])
    )
    turned = turn**2 + (shape / reach) ** 2
    terms = {
        "invariants/S_B": mass * shape,
        "invariants/T01_B": mass * shape * reach,
        "second_order/Z0_B": mass * reach * turned,
        "second_order/Z1_B": mass * reach**2 * turned,
        "second_order/G3": mass * shape * reach * turned,
        "second_order/G4": mass * (reach * turned) ** 2,
        "H_B": reach * turned,
        "second_order/pieces/h_B": reach * turned,
        "H_psi_B": turned,
    }
    found = {}
    for path, value in now.items():
        wanted = sum(weight * values[path] for weight, values in at) / (60.0 * h)
        given = sum(weight * values[path] for weight, values in near) / (0.06 * h)
        largest = max(
            np.abs(value).max(initial=0.0),
            terms.get(path, 0.0),
            terms.get(path.rpartition("/")[2], 0.0),
        )
        if largest > 0.0:
            found[path] = float(np.abs(given - wanted).max() * unit / largest)
        else:
            assert not np.any(wanted), path
    return found
