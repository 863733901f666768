"""Shapes of modes: a picture of the lowest, and one period of each for ParaView."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...dynamics.model.coordinates import moved
from ...math.arrays import Array
from ...package.common.container import new_file, set_text
from ...package.common.files import is_ours
from ...report.figures import segments
from ...report.style import PALE, Canvas, colour, house_style
from ...results import BodyGeometry, write_animation
from ...run.outcome import drawn_shapes
from .found import Found
from .state import States

FRAMES = 24  # of a period
_TURN = 0.6  # [rad] largest rotation of a node: torsion hardly moves the line of a beam
_SIZE = 0.07  # largest displacement, of the size of the mechanism
_DIFFERENCE = 1e-6  # amplitude for the displacement by a unit
_FLAT = 0.02  # extent across a plane, of that in it, up to which a motion is drawn in the plane
_COLUMNS = 3
_PATTERN = "mode-*.vtkhdf"


class Period(NamedTuple):
    """One period of a mode."""

    number: int
    title: str
    t: Array  # (FRAMES + 1,) [s]
    bodies: tuple[BodyGeometry, ...]
    rest: Array  # (n, 3) global positions of the nodes in the state [m]
    points: Array  # (FRAMES + 1, n, 3) with the mode, enlarged [m]


def draw_shapes(folder: Path, states: States, found: Found, count: int) -> list[str]:
    """Write modes.png and mode-NN.vtkhdf of the lowest modes; return the names of the files."""
    for old in filter(is_ours, folder.glob(_PATTERN)):
        old.unlink()
    n = min(count, found.modes.eigenvalues.size)
    if n == 0:
        if is_ours(folder / "modes.png"):
            (folder / "modes.png").unlink()
        return []
    periods = [period_of(states, found, k) for k in range(n)]
    digits = max(2, len(str(n)))
    for period in periods:
        _write(folder / f"mode-{period.number:0{digits}d}.vtkhdf", states, period)
    _draw(folder / "modes.png", periods)
    last = f" to mode-{n:0{digits}d}.vtkhdf" if n > 1 else ""
    return ["modes.png", f"mode-{1:0{digits}d}.vtkhdf{last}"]


def period_of(states: States, found: Found, k: int) -> Period:
    """Return one period of mode k, its its largest displacement _SIZE of the mechanism."""
    model, y = found.state.model, found.state.y
    x = found.modes.x[:, k]
    phase = np.exp(2j * np.pi * np.arange(FRAMES + 1) / FRAMES)

    def nodes(amplitude: float) -> tuple[tuple[BodyGeometry, ...], Array]:
        positions = [moved(model, y[: model.n_pos], amplitude * (x * p).real) for p in phase]
        still = np.zeros((len(phase), y.size - model.n_pos))
        return drawn_shapes(states.built, np.hstack([np.array(positions), still]))

    bodies, rest = nodes(0.0)
    size = float(np.linalg.norm(np.ptp(rest[0], axis=0))) or 1.0
    _, small = nodes(_DIFFERENCE)
    rate = float(np.linalg.norm(small - rest, axis=2).max()) / _DIFFERENCE
    turning = max(rate / (_SIZE * size), _rotation(states, x) / _TURN, 1e-300)
    _, points = nodes(1.0 / turning)
    w = float(found.modes.frequencies[k])
    title = f"{w / (2.0 * np.pi):.5g} Hz"
    if not w:
        real = found.modes.eigenvalues[k].real
        title = "0 Hz" if found.modes.still[k] else f"{real:+.4g} 1/s"
    title += f", {found.shares.main[k]}"
    times = np.arange(FRAMES + 1) / FRAMES * (2.0 * np.pi / w if w else 1.0)
    return Period(k + 1, title, times, bodies, rest[0], points)


def _rotation(states: States, x: Array) -> float:
    """Return the largest rotation of a frame, or of a node in it, by a motion x (n_vel,) [rad]."""
    model, largest = states.built.model, 0.0
    for i, name in enumerate(states.built.body_names):
        package = states.built.packages.get(name)
        j = int(model.vel_start[i]) + 6
        largest = max(largest, float(np.linalg.norm(np.abs(x[j - 3 : j]))))
        if package is not None:
            q = x[j : j + package.n_mode]
            found = np.einsum("mna,m->na", package.shapes_B[:, :, 3:6], q)
            largest = max(largest, float(np.linalg.norm(np.abs(found), axis=1).max()))
    return largest


def _write(path: Path, states: States, period: Period) -> None:
    with new_file(path) as file:
        set_text(file, "format", "plymotion mode")
        set_text(file, "case", states.spec.case)
        set_text(file, "run", states.spec.run)
        set_text(file, "mode", f"{period.number}: {period.title}")
        write_animation(file.create_group("VTKHDF"), period.bodies, period.t, period.points)


def _draw(path: Path, periods: list[Period]) -> None:
    columns = min(_COLUMNS, len(periods))
    rows = -(-len(periods) // columns)
    views = [_view(period) for period in periods]
    heights = [2.4 if len(keep) == 3 else 2.9 * high / wide for keep, wide, high in views]
    with house_style():
        canvas = Canvas(3.2 * columns, rows * (0.4 + min(max(*heights, 0.5), 2.6)))
        for k, (period, (keep, _, _)) in enumerate(zip(periods, views, strict=True)):
            more = {"projection": "3d"} if len(keep) == 3 else {}
            axes = canvas.figure.add_subplot(rows, columns, k + 1, **more)
            _lines(axes, period, keep)
            if len(keep) == 3:
                _box(axes, period)
            else:
                axes.set_aspect("equal", adjustable="datalim")
            plane = f" ({''.join('xyz'[a] for a in keep)})" if len(keep) == 2 else ""
            axes.set_title(f"{period.number}: {period.title}{plane}", fontsize=7)
            axes.set_axis_off()
        canvas.save(path)


def _every(period: Period) -> Array:
    return np.concatenate([period.rest, period.points.reshape(-1, 3)])


def _view(period: Period) -> tuple[list[int], float, float]:
    """Return the axes to draw in, two for a plane motion, and the extents along the first two."""
    spread = np.ptp(_every(period), axis=0)
    flat = float(spread.min()) < _FLAT * float(spread.max())
    keep = [a for a in range(3) if not (flat and a == int(spread.argmin()))]
    return keep, max(float(spread[keep[0]]), 1e-12), float(spread[keep[1]])


def _lines(axes: Any, period: Period, keep: list[int]) -> None:
    """Draw the state and four phases of the motion in the axes `keep`."""
    for points, ink, width in (
        (period.points[FRAMES // 4], colour(5), 0.6),
        (period.points[3 * FRAMES // 4], colour(5), 0.6),
        (period.rest, PALE, 1.0),
        (period.points[FRAMES // 2], colour(1), 0.8),
        (period.points[0], colour(0), 1.3),
    ):
        first = 0
        for body in period.bodies:
            own = points[first : first + len(body.nodes_B)]
            first += len(body.nodes_B)
            for line in segments(body, own):
                axes.plot(*line.T[keep], color=ink, linewidth=width)


def _box(axes: Any, period: Period) -> None:
    low, high = _every(period).min(axis=0), _every(period).max(axis=0)
    half = 0.5 * np.maximum(high - low, 0.25 * (float((high - low).max()) or 1.0))
    middle = 0.5 * (low + high)
    for limit, at, size in zip(
        (axes.set_xlim, axes.set_ylim, axes.set_zlim), middle, half, strict=True
    ):
        limit(at - size, at + size)
    axes.set_box_aspect(half, zoom=1.1)
