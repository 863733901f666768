"""A section's matrices in the order, signs and axes of other codes, and at other points.

In all these codes forces, moments, strains and curvatures are vectors, right-handed about the axes
of the section. They differ in the axis along the beam. A conversion is therefore a rotation; for
the blade axes of BeamDyn it may also reverse the direction of the beam. docs/conventions.md shows
the axes and the sources.
"""

from collections.abc import Sequence

import numpy as np

from ...errors import InputError, did_you_mean
from ...math.arrays import Array
from ...package.section.codes import AXES, CODES

# Blade axes of BeamDyn (x to the suction side, y to the trailing edge, z from root to tip) for
# sections whose x3 points to the suction side. With x2 to the trailing edge, as in airfoil
# coordinates, x1 points from tip to root.
Axes = Sequence[Sequence[float]] | Array
BLADE_AXES_TRAILING_EDGE: Axes = ((0, 0, 1), (0, 1, 0), (-1, 0, 0))
BLADE_AXES_LEADING_EDGE: Axes = ((0, 0, 1), (0, -1, 0), (1, 0, 0))

_SHAPES = {
    "stiffness": (6, 6),
    "mass": (6, 6),
    "compliance": (6, 6),
    "resultants": (6,),
    "strains": (6,),
}
KINDS = tuple(_SHAPES)


def convert(
    value: Array,
    to: str,
    kind: str = "stiffness",
    *,
    source: str = "plymotion",
    blade_axes: Axes = BLADE_AXES_TRAILING_EDGE,
) -> Array:
    """Return a matrix or vector of a section in the convention of another code.

    Parameters
    ----------
    value : (6, 6) stiffness, mass or compliance, or (6,) resultants or strains, of `source`
    to, source : one of CODES
    kind : one of KINDS
    blade_axes : (3, 3) rotation for BeamDyn: its local axes x, y, z as rows of components in
        x1, x2, x3; z is x1 or -x1. By default x2 points to the trailing edge and x3 to the
        suction side.

    The reference point does not change; BeamDyn needs it on its reference axis: see `transform`.

    Raises
    ------
    InputError : unknown code or kind, wrong shape, axes that are not a rotation.
    """
    old, new = _axes_of(source, blade_axes), _axes_of(to, blade_axes)
    A = new @ old.T  # v_to = A v_source
    # If the direction of the beam is reversed, its strains and the forces on the section's face
    # change sign.
    direction = _direction(old) * _direction(new)
    return _changed(_checked(value, kind), direction * _both(A).T, kind)


def transform(
    value: Array,
    translation: Array | tuple[float, float] = (0.0, 0.0),
    rotation: float = 0.0,
    kind: str = "stiffness",
) -> Array:
    """Return a matrix or vector of a section about another reference point and in rotated axes.

    Parameters
    ----------
    value : as in `convert`, in our order
    translation : (2,) x2 and x3 of the new reference point, in the old axes [m]
    rotation : angle of the new axes, from x2 towards x3 [rad]; the point moves first
    kind : one of KINDS

    Raises
    ------
    InputError : unknown kind, wrong shape.
    """
    value = _checked(value, kind)
    shift = np.asarray(translation, dtype=float)
    if shift.shape != (2,) or not np.isfinite(shift).all():
        raise InputError(f"translation = {translation!r}: expected x2 and x3 [m]")
    y, z = shift
    # Strains at the old point follow from those at the new one and the arm r = (0, y, z) between
    # them: gamma_old = gamma_new + r x kappa.
    move = np.eye(6)
    move[:3, 3:] = [[0.0, -z, y], [z, 0.0, 0.0], [-y, 0.0, 0.0]]
    c, s = np.cos(rotation), np.sin(rotation)
    turn = _both(np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]))
    return _changed(value, move @ turn.T, kind)


def _changed(value: Array, T: Array, kind: str) -> Array:
    """Value for new strains, with old strains = T times new strains and equal work."""
    if kind == "resultants":
        return np.asarray(T.T @ value)
    if kind == "strains":
        return np.asarray(np.linalg.solve(T, value))
    if kind == "compliance":
        inverse = np.linalg.inv(T)
        return np.asarray(inverse @ value @ inverse.T)
    return np.asarray(T.T @ value @ T)


def _both(A: Array) -> Array:
    """Rotation of forces and moments, (6, 6)."""
    return np.asarray(np.kron(np.eye(2), A), dtype=np.float64)


def _direction(axes: Array) -> float:
    """Return -1 if the beam axis is -x1, otherwise 1."""
    return -1.0 if axes[:, 0].sum() < 0.0 else 1.0


def _axes_of(code: str, blade_axes: Axes) -> Array:
    if code != "beamdyn":
        if code not in AXES:
            raise InputError(
                f"code = {code!r}: expected one of {', '.join(CODES)}" + did_you_mean(code, CODES)
            )
        return np.array(AXES[code], dtype=float)
    axes = np.asarray(blade_axes, dtype=float)
    good = axes.shape == (3, 3) and np.allclose(axes @ axes.T, np.eye(3), rtol=0, atol=1e-9)
    if not good or np.linalg.det(axes) < 0.0:
        raise InputError("blade_axes: expected a rotation (3, 3), orthonormal and right-handed")
    if abs(abs(axes[2, 0]) - 1.0) > 1e-9:
        raise InputError("blade_axes: expected a third row of 1 or -1, 0, 0: z along the beam")
    return axes


def _checked(value: Array, kind: str) -> Array:
    if kind not in _SHAPES:
        raise InputError(
            f"kind = {kind!r}: expected one of {', '.join(KINDS)}" + did_you_mean(kind, KINDS)
        )
    value = np.asarray(value, dtype=float)
    if value.shape != _SHAPES[kind]:
        raise InputError(f"{kind}: expected shape {_SHAPES[kind]}, got {value.shape}")
    return value
