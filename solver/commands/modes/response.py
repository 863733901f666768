"""`--response`: transfer functions from forces and drives to signals."""

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import InputError, nearest
from ...linearisation.response import frequencies_between, frequency_response
from ...math.arrays import Array
from ...package.common.temporary import write_text
from ...report.style import Canvas, colour, house_style
from .found import Found

POINTS = 400


@dataclass(frozen=True)
class Response:
    """Transfer functions over frequency."""

    hz: Array  # (k,)
    G: Array  # (k, n_out, n_in) complex
    inputs: list[tuple[str, str]]  # name and unit
    outputs: list[tuple[str, str]]


def span_of(text: str) -> tuple[float, float]:
    """Read LOW:HIGH of `--response` [Hz]. Raises InputError."""
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        low = high = np.nan
    if not 0.0 < low < high < np.inf:
        raise InputError(f"--response {text}: expected LOW:HIGH in Hz, 0 < LOW < HIGH")
    return low, high


def response_of(
    found: Found, span: tuple[float, float], inputs: list[str] | None, outputs: list[str] | None
) -> Response:
    """Return the transfer functions between named inputs and outputs; None: all of them.

    Raises
    ------
    InputError
        An unknown name; a case without inputs or signals.
    """
    space = found.space
    into = _chosen("--input", inputs, [s.name for s in space.inputs], "drive, load or actuator")
    out = _chosen("--output", outputs, [name for name, _ in space.outputs], "signal")
    low, high = (2.0 * np.pi * f for f in span)
    w = frequencies_between(low, high, POINTS, found.modes.frequencies)
    G = frequency_response(space, w)[:, out][:, :, into]
    pairs = [(space.inputs[k].name, space.inputs[k].unit) for k in into]
    return Response(w / (2.0 * np.pi), G, pairs, [space.outputs[k] for k in out])


def _chosen(option: str, names: list[str] | None, known: list[str], what: str) -> list[int]:
    if not known:
        raise InputError(f"--response: the case has no {what}")
    for name in names or ():
        if name not in known:
            raise InputError(f"{option} {name}: no such {what}{nearest(name, known)}")
    return [known.index(name) for name in names or known]


def write_response(folder: Path, response: Response) -> None:
    """Write response.csv (magnitude and phase of each pair) and response.png."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    head, columns = ["frequency [Hz]"], [response.hz]
    for i, (output, unit) in enumerate(response.outputs):
        for j, (name, by) in enumerate(response.inputs):
            head += [f"{name} -> {output} [{unit} / ({by})]", f"{name} -> {output} phase [deg]"]
            g = response.G[:, i, j]
            columns += [np.abs(g), np.degrees(np.angle(g))]
    writer.writerow(head)
    writer.writerows([[repr(float(v)) for v in row] for row in np.array(columns).T])
    write_text(folder / "response.csv", out.getvalue())
    _draw(folder / "response.png", response)


def _draw(path: Path, response: Response) -> None:
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
