"""Files of modes and Campbell diagrams: numbers, matrices, and shapes as pictures."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.io import savemat

from ...dynamics.model.coordinates import moved
from ...math.arrays import Array
from ...package.common.container import new_file, set_text
from ...package.common.files import is_ours, refuse_foreign, temporary_sibling, write_text
from ...package.common.plain_data import csv_text
from ...report.case_figures import segments
from ...report.style import PALE, Canvas, colour, house_style
from ...results import BodyGeometry, write_animation
from ...run.outcome import drawn_shapes
from ..linearisation.modes import coordinate_names
from ..linearisation.state_space import Realisation, realisation
from .state import States
from .state_modes import Diagram, Found, Response, draw


def write_modes(
    folder: Path, result: Found, shapes: int, response: Response | None = None
) -> list[str]:
    """Write modes.json, linear.npz, linear.mat, the lowest shapes and a response, if any.

    Return the names of the files.

    Parameters
    ----------
    folder : folder of the files
    result : modes about a state
    shapes : number of shapes to draw
    response : transfer functions; None: none asked for
    """
    refuse_foreign(folder / "modes.json")
    folder.mkdir(parents=True, exist_ok=True)
    _write_linear(folder, result)
    write_text(folder / "modes.json", json.dumps(modes_content(result), indent=2) + "\n")
    files = ["modes.json", "linear.npz", "linear.mat"]
    if response is not None:
        # Magnitude and phase of each pair.
        head, columns = ["frequency [Hz]"], [response.hz]
        for i, (output, unit) in enumerate(response.outputs):
            for j, (name, by) in enumerate(response.inputs):
                head += [f"{name} -> {output} [{unit} / ({by})]", f"{name} -> {output} phase [deg]"]
                g = response.G[:, i, j]
                columns += [np.abs(g), np.degrees(np.angle(g))]
        write_text(folder / "response.csv", csv_text([head, *np.array(columns).T.tolist()], "\n"))
        _draw_response(folder / "response.png", response)
        files += ["response.csv", "response.png"]
    return [*files, *draw_shapes(folder, result, shapes)]


def write_campbell(folder: Path, diagram: Diagram) -> list[str]:
    """Write campbell.png, campbell.csv and campbell.json; return the names of the files."""
    refuse_foreign(folder / "campbell.json")
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / "campbell.csv", diagram.csv())
    write_text(folder / "campbell.json", json.dumps(diagram.content(), indent=2) + "\n")
    draw(folder / "campbell.png", diagram)  # after the numbers: it needs matplotlib
    return ["campbell.png", "campbell.csv", "campbell.json"]


# modes.json: the modes as plain data.


def modes_content(result: Found) -> dict[str, object]:
    """Return the content of modes.json."""
    spec, state, rank = result.states.spec, result.state, result.space.rank
    spin = None
    if state.spin is not None:
        spin = {
            "axis": state.spin.axis.tolist(),
            "point": state.spin.point.tolist(),
            "speed": state.spin.rate,
        }
    return {
        "case": spec.case,
        "run": spec.run,
        "state": state.words,
        "t": state.t,
        "spin": spin,
        "degrees_of_freedom": result.space.n_free,
        "constraints": {
            "rows": rank.rows,
            "rank": rank.value,
            "smallest_counted": rank.last,
            "largest_dropped": rank.first,
            "doubtful": rank.doubtful,
            "text": rank.text,
        },
        "difference_error": result.space.error,
        "modes": [mode._asdict() for mode in result.each],
        "notes": list(result.notes),
    }


# Transfer functions over frequency.


def _draw_response(path: Path, response: Response) -> None:
    n = len(response.outputs)
    with house_style():
        canvas = Canvas(7.2, 0.6 + 2.4 * n)
        panels = canvas.panels(n, 2, sharex=True, width_ratios=(3, 2))
        for i, (output, unit) in enumerate(response.outputs):
            size, phase = panels[2 * i], panels[2 * i + 1]
            for j, (name, by) in enumerate(response.inputs):
                g = response.G[:, i, j]
                label = f"{name} [{by}]"
                size.loglog(
                    response.hz, np.maximum(np.abs(g), 1e-300), color=colour(j), label=label
                )
                phase.semilogx(response.hz, np.degrees(np.angle(g)), color=colour(j))
            size.set_title(f"{output} [{unit}] per unit of input")
            phase.set_title("phase [deg]")
            phase.set_ylim(-190.0, 190.0)
            phase.set_yticks((-180, -90, 0, 90, 180))
            size.legend(loc="best")
        for axes in panels[-2:]:
            axes.set_xlabel("frequency [Hz]")
        canvas.save(path)


# Linearised equations as files for NumPy and MATLAB.


def linear_system(result: Found) -> Realisation:
    """Return the linearised equations: A, B, C, D with names and units of what they connect."""
    built = result.states.built
    names = coordinate_names(built.model, built.body_names, built.packages)
    return realisation(result.space, names, built.state_names)


def _write_linear(folder: Path, result: Found) -> None:
    """Write linear.npz and linear.mat: A, B, C, D with names and units of what they connect."""
    system = linear_system(result)._asdict()
    matrices: dict[str, Array] = {key: system.pop(key) for key in "ABCD"}
    matrices |= {
        "eigenvalues": result.modes.eigenvalues,
        "shapes": result.modes.x,
        "t": np.array(result.state.t),
        "spin": result.state.spin.W if result.state.spin is not None else np.zeros(3),
    }
    texts = {key: np.array(values, dtype=str) for key, values in system.items()}
    content = matrices | texts
    with temporary_sibling(folder / "linear.npz") as temporary:
        np.savez(temporary, **content)
    cells = {key: np.array(values, dtype=object)[:, None] for key, values in system.items()}
    with temporary_sibling(folder / "linear.mat") as temporary:
        savemat(temporary, {**matrices, **cells}, do_compression=True)


# Shapes of modes: a picture of the lowest, and one period of each for ParaView.

FRAMES = 24  # of a period
_TURN = 0.6  # [rad] largest rotation of a node: torsion hardly moves the line of a beam
_SIZE = 0.07  # largest displacement, of the size of the mechanism
_DIFFERENCE = 1e-6  # amplitude for the displacement by a unit
_FLAT = 0.02  # extent across a plane, of that in it, up to which a motion is drawn in the plane
_COLUMNS = 3
_MANY = 300  # lines from which they are thinner
_PATTERN = "mode-*.vtkhdf"


class Period(NamedTuple):
    """One period of a mode."""

    number: int
    title: str
    t: Array  # (FRAMES + 1,) [s]
    bodies: tuple[BodyGeometry, ...]
    rest: Array  # (n, 3) global positions of the nodes in the state [m]
    points: Array  # (FRAMES + 1, n, 3) with the mode, enlarged [m]


def draw_shapes(folder: Path, result: Found, count: int) -> list[str]:
    """Write modes.png and mode-NN.vtkhdf of the lowest modes; return the names of the files.

    Parameters
    ----------
    folder : folder of the files
    result : modes about a state
    count : largest number of shapes
    """
    for old in filter(is_ours, folder.glob(_PATTERN)):
        old.unlink()
    n = min(count, result.modes.eigenvalues.size)
    if n == 0:
        if is_ours(folder / "modes.png"):
            (folder / "modes.png").unlink()
        return []
    periods = [period_of(result, k) for k in range(n)]
    digits = max(2, len(str(n)))
    for period in periods:
        with new_file(folder / f"mode-{period.number:0{digits}d}.vtkhdf") as file:
            set_text(file, "format", "plymotion mode")
            set_text(file, "case", result.states.spec.case)
            set_text(file, "run", result.states.spec.run)
            set_text(file, "mode", f"{period.number}: {period.title}")
            write_animation(file.create_group("VTKHDF"), period.bodies, period.t, period.points)
    _draw_shapes(folder / "modes.png", periods)
    last = f" to mode-{n:0{digits}d}.vtkhdf" if n > 1 else ""
    return ["modes.png", f"mode-{1:0{digits}d}.vtkhdf{last}"]


def period_of(result: Found, k: int) -> Period:
    """Return one period of mode k, with a largest displacement of _SIZE times the mechanism.

    Parameters
    ----------
    result : modes about a state
    k : number of the mode
    """
    states, model, y = result.states, result.state.model, result.state.y
    x = result.modes.x[:, k]
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
    w = float(result.modes.frequencies[k])
    title = f"{w / (2.0 * np.pi):.5g} Hz"
    if not w:
        real = result.modes.eigenvalues[k].real
        title = "0 Hz" if result.modes.still[k] else f"{real:+.4g} 1/s"
    title += f", {result.shares.main[k]}"
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
            rotations = np.einsum("mna,m->na", package.shapes_B[:, :, 3:6], q)
            largest = max(largest, float(np.linalg.norm(np.abs(rotations), axis=1).max()))
    return largest


def _draw_shapes(path: Path, periods: list[Period]) -> None:
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
    from matplotlib.collections import LineCollection
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    for points, ink, width in (
        (period.points[FRAMES // 4], colour(5), 0.6),
        (period.points[3 * FRAMES // 4], colour(5), 0.6),
        (period.rest, PALE, 1.0),
        (period.points[FRAMES // 2], colour(1), 0.8),
        (period.points[0], colour(0), 1.3),
    ):
        first, lines = 0, []
        for body in period.bodies:
            own = points[first : first + len(body.nodes_B)]
            first += len(body.nodes_B)
            lines += [line[:, keep] for line in segments(body, own)]
        # One collection for all: a line of its own for each cell takes minutes for a solid.
        kind = Line3DCollection if len(keep) == 3 else LineCollection
        thinner = min(1.0, (_MANY / max(len(lines), 1)) ** 0.5)
        axes.add_collection(kind(lines, colors=[ink], linewidths=width * thinner))
    axes.autoscale_view()


def _box(axes: Any, period: Period) -> None:
    low, high = _every(period).min(axis=0), _every(period).max(axis=0)
    half = 0.5 * np.maximum(high - low, 0.25 * (float((high - low).max()) or 1.0))
    middle = 0.5 * (low + high)
    for limit, at, size in zip(
        (axes.set_xlim, axes.set_ylim, axes.set_zlim), middle, half, strict=True
    ):
        limit(at - size, at + size)
    axes.set_box_aspect(half, zoom=1.1)
