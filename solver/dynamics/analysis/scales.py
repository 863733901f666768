"""Size, speed and energy of a mechanism, from its start: the units of its tolerances."""

from typing import NamedTuple

import numpy as np

from ...math.arrays import Array
from ..elements.joints.table import position_rows
from ..evaluation.energy import stored_energies
from ..evaluation.evaluation import evaluate
from ..evaluation.series import along_solution, driven_speeds, marker_places
from ..model.model import Model
from ..model.workspace import spare_work

SAMPLES = 65  # times at which drives are looked at
# Pivots below which elimination leaves no digit. Above it orders of magnitude are right, and the
# time stays linear in the number of bodies: the pivots of a chain fall with its length.
ORDER = 1e-12


class Scales(NamedTuple):
    """Orders of magnitude of what a run goes through."""

    length: float  # [m]
    speed: float  # of points [m/s]
    energy: float  # [J]


def scales(model: Model, y0: Array, t_end: float) -> Scales:
    """Return the scales of a run from state y0 (n,) to t_end [s].

    Length: the diagonal of the box around all markers and frames, or the largest radius of
    gyration; 1 m for a mass point without either. Speed: the largest of
    - the speeds at the start, of frames and, by their spin, at the distance of the length;
    - those of drives at any time;
    - the length over t_end;
    - after the length under gravity, or at the accelerations of the start; with springs, bushings
      and dampers, whose accelerations may last for an instant, that of the energy stored in them.
    Energy: that of all masses at this speed.
    """
    length = extent(model, y0)
    driven = speed_of_drives(model, y0, np.linspace(0.0, t_end, SAMPLES), length)
    speed = max(length / t_end, _at_start(model, y0, length), driven)
    return Scales(length, speed, float(model.mass.sum()) * speed**2)


def shape_sizes(model: Model, i: int) -> Array:
    """Return the displacement of body i by a unit of each mode, (m,): root mean square by mass."""
    m, two = int(model.n_mode[i]), int(model.square_start[i])
    diagonal = model.M_qq[two : two + m * m].reshape(m, m).diagonal()
    return np.asarray(np.sqrt(diagonal / model.mass[i]))


def extent(model: Model, y0: Array) -> float:
    """Return the size of a mechanism in state y0 (n,), the length of `scales` [m]."""
    frames = y0[np.asarray(model.pos_start)[:, None] + np.arange(3)]
    points = np.concatenate([frames, marker_places(model, y0)])
    box = float(np.linalg.norm(np.ptp(points, axis=0)))
    held = model.mass > 0.0
    square = np.trace(model.T00[held], axis1=1, axis2=2) / model.mass[held]
    return max(box, float(np.sqrt(square.max(initial=0.0)))) or 1.0


def _at_start(model: Model, y0: Array, length: float) -> float:
    """Speed at the start, and what gravity and loads can make of it over the length [m/s]."""
    rates, _ = along_solution(model, np.zeros(1), y0[None], ORDER)
    fall = float(np.linalg.norm(model.gravity_G)) * length
    mass = max(float(model.mass.sum()), 1e-300)
    work = spare_work(model)
    evaluate(model, work, 0.0, y0)
    energies = np.zeros(3)
    stored_energies(model, y0, work.P, energies)
    stored = energies[1] + work.power[1]
    gain = max(fall, 2.0 * abs(float(stored)) / mass)
    if model.plan.element_row.shape[0] == 0:
        gain = max(
            gain,
            _of_frames(model, rates[0, model.n_pos : model.n_pos + model.n_vel], length) * length,
        )
    return max(
        _of_frames(model, y0[model.n_pos : model.n_pos + model.n_vel], length), float(np.sqrt(gain))
    )


def _of_frames(model: Model, v: Array, length: float) -> float:
    """Return the largest size in v (n_vel,) of frames; of spins, at the distance of the length."""
    first = np.asarray(model.vel_start)[:, None]
    moved = np.linalg.norm(v[first + np.arange(3)], axis=1)
    turned = np.linalg.norm(v[first + np.arange(3, 6)], axis=1) * length
    largest = float(np.max([moved, turned], initial=0.0))
    return largest if np.isfinite(largest) else 0.0


def speed_of_drives(model: Model, y0: Array, times: Array, length: float) -> float:
    """Return the largest speed that drives prescribe at times (k,) [m/s]; of turns, at a length."""
    if not (model.joint_law >= 0).any():
        return 0.0
    arm = np.where(position_rows(model.joint_kind), 1.0, length)
    speeds = driven_speeds(model, times, y0)
    return float(np.fmax.reduce(np.abs(speeds) * arm, axis=None, initial=0.0))
