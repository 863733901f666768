"""Files of modes and Campbell diagrams."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from ...inputs.case.write import dump
from ...package.common.files import refuse_foreign, temporary_sibling, write_text
from ...package.common.plain_data import csv_text
from ...report.style import Canvas, colour, house_style
from ..linearisation.modes import coordinate_names
from ..linearisation.state_space import Realisation, realisation
from .found import Diagram, Found, Response, draw
from .shapes import draw_shapes
from .state import States


def write_modes(
    folder: Path, states: States, found: Found, shapes: int, response: Response | None
) -> list[str]:
    """Write modes.json, linear.npz, linear.mat, the lowest shapes and a response, if any.

    Return the names of the files.
    """
    refuse_foreign(folder / "modes.json")
    folder.mkdir(parents=True, exist_ok=True)
    _write_linear(folder, states, found)
    write_text(folder / "modes.json", dump(modes_content(states, found)))
    files = ["modes.json", "linear.npz", "linear.mat"]
    if response is not None:
        _write_response(folder, response)
        files += ["response.csv", "response.png"]
    return [*files, *draw_shapes(folder, states, found, shapes)]


def write_campbell(folder: Path, diagram: Diagram) -> list[str]:
    """Write campbell.png, campbell.csv and campbell.json; return the names of the files."""
    refuse_foreign(folder / "campbell.json")
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / "campbell.csv", diagram.csv())
    write_text(folder / "campbell.json", dump(diagram.content()))
    draw(folder / "campbell.png", diagram)  # after the numbers: it needs matplotlib
    return ["campbell.png", "campbell.csv", "campbell.json"]


# modes.json: the modes as plain data.


def modes_content(states: States, found: Found) -> dict[str, object]:
    """Return the content of modes.json."""
    state, rank = found.state, found.space.rank
    spin = None
    if state.spin is not None:
        spin = {
            "axis": state.spin.axis.tolist(),
            "point": state.spin.point.tolist(),
            "speed": state.spin.rate,
        }
    return {
        "case": states.spec.case,
        "run": states.spec.run,
        "state": state.words,
        "t": state.t,
        "spin": spin,
        "degrees_of_freedom": found.space.n_free,
        "constraints": {
            "rows": rank.rows,
            "rank": rank.value,
            "smallest_counted": rank.last,
            "largest_dropped": rank.first,
            "doubtful": rank.doubtful,
            "text": rank.text,
        },
        "difference_error": found.space.error,
        "modes": [_entry(found, states.built.body_names, k) for k in range(len(found.whirl))],
        "notes": list(found.notes),
    }


def _entry(found: Found, body_names: list[str], k: int) -> dict[str, object]:
    """Return mode k as plain data."""
    value, w = found.modes.eigenvalues[k], float(found.modes.frequencies[k])
    still, whirl = bool(found.modes.still[k]), float(found.whirl[k])
    shares = found.shares.bodies[:, k].tolist()
    return {
        "number": k + 1,
        "frequency_hz": w / (2.0 * np.pi),
        "angular_frequency": w,
        "damping_ratio": float(found.damping[k]),
        "eigenvalue": [0.0, 0.0] if still else [float(value.real), float(value.imag)],
        "kind": "zero" if still else "oscillation" if w > 0.0 else "real",
        "fixed_axes_angular_frequency": None if np.isnan(whirl) else whirl,
        "main": found.shares.main[k],
        "bodies": dict(zip(body_names, shares, strict=False)),
    }


# Transfer functions over frequency.


def _write_response(folder: Path, response: Response) -> None:
    """Write response.csv (magnitude and phase of each pair) and response.png."""
    head, columns = ["frequency [Hz]"], [response.hz]
    for i, (output, unit) in enumerate(response.outputs):
        for j, (name, by) in enumerate(response.inputs):
            head += [f"{name} -> {output} [{unit} / ({by})]", f"{name} -> {output} phase [deg]"]
            g = response.G[:, i, j]
            columns += [np.abs(g), np.degrees(np.angle(g))]
    write_text(folder / "response.csv", csv_text([head, *np.array(columns).T.tolist()], "\n"))
    _draw_response(folder / "response.png", response)


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


def linear_system(states: States, found: Found) -> Realisation:
    """Return the linearised equations: A, B, C, D with names and units of what they connect."""
    built = states.built
    names = coordinate_names(built.model, built.body_names, built.packages)
    return realisation(found.space, names, built.state_names)


def _write_linear(folder: Path, states: States, found: Found) -> None:
    """Write linear.npz and linear.mat: A, B, C, D with names and units of what they connect."""
    system = linear_system(states, found)._asdict()
    matrices: dict[str, Any] = {key: system.pop(key) for key in "ABCD"}
    matrices |= {
        "eigenvalues": found.modes.eigenvalues,
        "shapes": found.modes.x,
        "t": np.array(found.state.t),
        "spin": found.state.spin.W if found.state.spin is not None else np.zeros(3),
    }
    texts = {key: np.array(words, dtype=str) for key, words in system.items()}
    content = matrices | texts
    with temporary_sibling(folder / "linear.npz") as temporary:
        np.savez(temporary, **content)
    cells = {key: np.array(words, dtype=object)[:, None] for key, words in system.items()}
    with temporary_sibling(folder / "linear.mat") as temporary:
        savemat(temporary, {**matrices, **cells}, do_compression=True)
