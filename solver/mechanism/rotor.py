"""The rotor of a case as loads on its blades, states and arrays of the model."""

from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.model.model import ANGLE_STEP, N_SECTION_STATE
from ..errors import InputError
from ..math.arrays import Array
from ..math.expressions.program import constant
from ..math.laws import Law
from ..math.rotations import vector_to_matrix
from .places import Places, axes
from .tables import ForceTable, Measured, RotorTable, StateTable

if TYPE_CHECKING:
    from ..inputs.case.tables.rotor import Polar, RotorSection
    from ..inputs.case.tables.rotor import Rotor as RotorKeys

# Sizes of the states, for the tolerance of their error: induced velocities [m/s], separation, wake.
SIZES = (1.0, 1.0, 1.0, 1.0, 0.1, 0.1, 0.1)
SEPARATED = np.radians([30.0, 50.0])  # from lift with a lag to lift without one


def rotor_table(
    keys: "RotorKeys", wind_laws: tuple[Law, Law], places: Places, measured: Measured
) -> RotorTable:
    """Return the rotor of a case.

    Parameters
    ----------
    keys : table [rotor] of the case
    wind_laws : laws of wind speed [m/s] and of the turn of its direction [rad]
    places : places of the mechanism, with their markers
    measured : quantities and states of the model; gets the states of the rotor

    Raises
    ------
    InputError : a package without an interface of the sections.
    """
    centre, n = _centre(keys, places)
    known = sorted({section.polar for section in keys.sections})
    state, forces, shape = len(measured.states), [], []
    for blade in keys.blades:
        hub = places.marker("rotor.hub", keys.hub, axes(keys.axis))
        frames, points = _frames(keys, blade, places)
        r = np.linalg.norm((points - centre) - np.outer((points - centre) @ n, n), axis=1)
        half = 0.5 * np.array([keys.sections[0].width, keys.sections[-1].width])
        slope = np.gradient(r) / np.linalg.norm(np.gradient(points, axis=0), axis=1)
        root, tip = r[0] - half[0] * slope[0], r[-1] + half[1] * slope[-1]
        _check_sizes(keys, blade, points, r)
        for k, section in enumerate(keys.sections):
            place = _place(keys, blade, section)
            marker = places.marker("rotor.sections.place", place, frames[k])
            name = f"rotor.{blade}.{section.place}"
            forces.append(ForceTable(name, "force", hub, marker))
            gaps = (tip - r[k]) / r[k], (r[k] - root) / max(root, 1e-3 * tip)
            shape.append([section.chord, section.width, section.offset, *gaps])
            for i, size in enumerate(SIZES):
                measured.state(
                    StateTable(f"{name}.{i + 1}", None, constant(0.0), size, owner="rotor")
                )
    assert len(measured.states) == state + N_SECTION_STATE * len(forces)
    wind = keys.wind
    up, along = (np.array(v) / np.linalg.norm(v) for v in (wind.up, wind.direction))
    air = [keys.air_density, len(keys.blades), tip, wind.shear_exponent, wind.reference_height]
    return RotorTable(
        tuple(forces),
        wind_laws,
        np.array([known.index(s.polar) for s in keys.sections] * len(keys.blades), dtype=np.int64),
        np.array(shape),
        np.array([polar_rows(keys.polars[name]) for name in known]),
        np.array([*air, *up, *along, float(keys.induction == "madsen")]),
        state,
    )


def _check_sizes(keys: "RotorKeys", blade: str, points: Array, r: Array) -> None:
    """Raise InputError for strips that do not lead away from the axis, or are larger than it."""
    if not (np.diff(r) > 0.0).all() or np.ptp(r) < 0.5 * np.linalg.norm(points[-1] - points[0]):
        raise InputError(
            f"rotor.axis = {keys.axis}: the strips of {blade} begin at {r[0]:g} m and end at "
            f"{r[-1]:g} m from this axis through the hub; expected them in order, away from it"
        )
    widths, chord = sum(s.width for s in keys.sections), max(s.chord for s in keys.sections)
    if max(widths / 1.5, chord) > r[-1]:
        raise InputError(
            f"rotor: the widths of the strips of {blade} add up to {widths:g} m, the chords go up "
            f"to {chord:g} m, but the last strip is at {r[-1]:g} m; expected lengths in m"
        )


def _centre(keys: "RotorKeys", places: Places) -> tuple[Array, Array]:
    marker = places.marker("rotor.hub", keys.hub, axes(keys.axis))
    x, A = places.frame(marker)
    return x, A[:, 2]


def _place(keys: "RotorKeys", blade: str, section: "RotorSection") -> str:
    """Return "BODY.INTERFACE" of a strip, of the segment if the blade has some."""
    divided = keys.divided.get(blade)
    return divided.places[section.place] if divided else f"{blade}.{section.place}"


def _frames(keys: "RotorKeys", blade: str, places: Places) -> tuple[Array, Array]:
    """Return axes (n, 3, 3) and places (n, 3) of the sections of a blade at the start, global."""
    markers = [
        places.marker(f'rotor.blades: "{blade}"', _place(keys, blade, section), np.eye(3))
        for section in keys.sections
    ]
    points = np.array([places.frame(marker)[0] for marker in markers])
    if blade in keys.divided:
        A = vector_to_matrix(np.radians(np.array(keys.divided[blade].rotation_deg)))
    else:
        A = places.A_start[places.known[f"{blade}.{keys.sections[0].place}"][0]]
    y = A[:, 1]
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    flat = y - (along @ y)[:, None] * along
    flat /= np.linalg.norm(flat, axis=1)[:, None]
    up = np.cross(along, flat)
    twist = np.radians([section.twist_deg for section in keys.sections])[:, None]
    ahead = np.cos(twist) * flat + np.sin(twist) * up
    return np.stack([along, ahead, np.cross(along, ahead)], axis=2), points


def polar_rows(polar: "Polar") -> Array:
    """Return a polar in equal steps from -pi to pi, (n, N_POLAR), with separation by its lift.

    Lift f cl_attached + (1 - f) cl_separated, cl_attached = slope (alpha - alpha_0) and
    f = (2 sqrt(cl / cl_attached) - 1)^2 from 1 to 0 (M. H. Hansen et al., Riso-R-1354, eqs. 10
    to 15).
    """
    from scipy.interpolate import PchipInterpolator  # slow to import; other runs do without it

    alpha = ANGLE_STEP * np.arange(round(2.0 * np.pi / ANGLE_STEP) + 1) - np.pi
    given = np.radians(polar.alpha_deg)
    columns = np.column_stack([polar.cl, polar.cd, polar.cm])
    cl, cd, cm = PchipInterpolator(given, columns)(alpha).T
    near = np.flatnonzero(np.abs(alpha) < np.radians(20.0))
    rising = near[:-1][(cl[near[:-1]] <= 0.0) & (cl[near[1:]] > 0.0)]
    f, span = np.ones(alpha.size), np.zeros(alpha.size)
    if rising.size:
        k = rising[np.abs(alpha[rising]).argmin()]
        zero = alpha[k] - cl[k] * ANGLE_STEP / (cl[k + 1] - cl[k])
        away = alpha - zero
        slopes = cl[near] / np.where(np.abs(away[near]) > np.radians(2.0), away[near], np.inf)
        attached = slopes.max() * away
        share = np.clip(cl / np.where(attached == 0.0, 1.0, attached), 0.25, 1.0)
        f = (2.0 * np.sqrt(share) - 1.0) ** 2
        f[np.abs(away) < np.radians(2.0)] = 1.0
        for part in (f[k + 1 :], f[k::-1]):  # away from zero lift it does not attach again
            np.minimum.accumulate(part, out=part)
        whole = f > 1.0 - 1e-6
        separated = np.where(whole, 0.5 * cl, (cl - f * attached) / np.where(whole, 1.0, 1.0 - f))
        begin, end = SEPARATED
        span = np.clip((end - np.abs(away)) / (end - begin), 0.0, 1.0) * (attached - separated)
    return np.column_stack([cl, cd, cm, f, span])
