"""The command `plymotion modes`."""

import argparse
from math import pi
from pathlib import Path

import numpy as np

from ..report.table import aligned, json_text
from ..studies.modes.files import modes_content, write_campbell, write_modes
from ..studies.modes.place import at_of
from ..studies.modes.state import States, read_spec
from ..studies.modes.state_modes import (
    RPM,
    Diagram,
    Found,
    Mode,
    Spins,
    find_modes,
    response_of,
    span_of,
)

# Modes as a table for the screen.

_SHARE = 0.05  # of the energy, from which a body is named
_COLUMNS = 8  # branches on the screen
_BODIES = 3  # named for a mode


def modes_text(result: Found, count: int) -> str:
    """Return the table of the modes about a state."""
    spec, state, axes = result.states.spec, result.state, ""
    if state.spin is not None and (speed := state.spin.rate):
        x, y, z = state.spin.axis
        axes = f", in axes that turn at {speed:.6g} rad/s about ({x:.3g}, {y:.3g}, {z:.3g})"
    title = f"{spec.case}, run {spec.run}: modes about {state.words}{axes}"
    whirl = any(m.fixed_axes_angular_frequency is not None for m in result.each)
    head = ["mode", "frequency", "", "damping", "fixed axes", "main coordinate", "bodies"]
    units = ["", "[Hz]", "[rad/s]", "[-]", "[rad/s]", "", "share of kinetic energy"]
    rows = []
    for m in result.each:
        w = m.fixed_axes_angular_frequency
        seen = "" if w is None else f"{w:+.7g}"
        rows.append([str(m.number), *_numbers(m), seen, m.main, _bodies(m)])
    table = [head, units, *rows[:count]]
    if not whirl:
        table = [row[:4] + row[5:] for row in table]
    left = tuple(range(len(table[0]) - 2, len(table[0])))
    lines = [title, "", aligned(table, left=left)]
    if len(rows) > count:
        lines.append(f"... and {len(rows) - count} more, see modes.json")
    lines += ["", f"{result.space.n_free} degrees of freedom; {result.space.rank.text}"]
    if zeros := sum(m.kind == "zero" for m in result.each):
        lines.append(f"{zeros} motions without stiffness: frequency 0")
    return "\n".join([*lines, *(f"note: {note}" for note in result.notes)])


def campbell_text(diagram: Diagram) -> str:
    """Return the tables of a Campbell diagram."""
    spec, fixed, branches = diagram.spins.states.spec, diagram.fixed, diagram.branches[:_COLUMNS]
    table = [["speed", *(f"{b.branch}" for b in branches)]]
    table.append(["[rad/s]", *("[Hz]" for _ in branches)])
    for s, speed in enumerate(diagram.speeds):
        cells = [(b.seen(fixed)[s], "*" if b.growth[s] else "") for b in branches]
        hertz = ["-" if w is None else f"{abs(w) / (2.0 * pi):.6g}{star}" for w, star in cells]
        table.append([f"{speed:.6g}", *hertz])
    seen = "at rest" if fixed else "that turn with the mechanism"
    lines = [
        f"{spec.case}, run {spec.run}: frequencies seen from axes {seen}",
        "",
        aligned(table, left=()),
        "",
        *(f"{b.branch:4d}  {b.main}" for b in branches),
    ]
    if (more := len(diagram.names) - _COLUMNS) > 0:
        lines.append(f"... {more} more in campbell.csv")
    if any(g for b in branches for g in b.growth):
        lines.append("* unstable")
    table = [
        ["crossing", "branch", "speed", "", "frequency"],
        ["", "", "[rad/s]", "[1/min]", "[Hz]"],
    ]
    for x in diagram.crossings:
        rates = [f"{x.speed:.6g}", f"{x.speed * RPM:.6g}", f"{x.frequency / (2.0 * pi):.6g}"]
        table.append([f"{x.harmonic}P", str(x.branch + 1), *rates])
    crossings = aligned(table, left=()) if diagram.crossings else "no crossings with harmonics"
    return "\n".join([*lines, "", crossings, *(f"note: {note}" for note in diagram.spins.notes)])


def _numbers(mode: Mode) -> list[str]:
    if mode.kind == "zero":
        return ["0", "0", "-"]
    if mode.kind == "real":
        return ["-", f"{mode.eigenvalue[0]:+.5g} 1/s", "-"]
    damping = f"{mode.damping_ratio:.4g}" if abs(mode.damping_ratio) > 1e-9 else "0"
    return [f"{mode.frequency_hz:.6g}", f"{mode.angular_frequency:.7g}", damping]


def _bodies(mode: Mode) -> str:
    shares = sorted(mode.bodies.items(), key=lambda item: -item[1])
    parts = [f"{name} {100 * share:.0f} %" for name, share in shares if share >= _SHARE]
    return ", ".join(parts[:_BODIES])


# The command `plymotion modes`.


def run_modes(options: argparse.Namespace) -> int:
    """Linearise a run about a state; return 0."""
    at = at_of(options.at)
    span = None if options.response is None else span_of(options.response)
    spec, build = read_spec(
        options.case,
        options.run,
        packages=options.packages,
        coarse=options.coarse,
    )
    label = options.at.replace("=", "").replace(":", "-")
    folder: Path = options.out or build / "modes" / f"{spec.run}-{label}"
    axis = None if options.axis is None else np.array(options.axis)
    states = States(spec)
    if at.kind == "spin" and at.speeds is not None and at.speeds.size > 1:
        spins = Spins(states, axis)
        diagram = Diagram(spins, at.speeds, options.count, options.harmonics, options.axes)
        print(json_text(diagram.content()) if options.json else campbell_text(diagram))
        files = write_campbell(folder, diagram)
    else:
        modes, response = find_modes(states, states.at(at, axis)), None
        if span is not None:
            response = response_of(modes, span, options.input, options.output)
        # First: figures can fail. JSON is alone on standard output.
        json = options.json
        print(json_text(modes_content(modes)) if json else modes_text(modes, options.count))
        files = write_modes(folder, modes, options.shapes, response)
    if not options.json:
        print(f"{folder}: {', '.join(files)}")
    return 0
