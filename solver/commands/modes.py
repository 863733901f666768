"""The command `plymotion modes`."""

import argparse
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from ..report.table import aligned, json_text
from ..studies.modes.files import modes_content, write_campbell, write_modes
from ..studies.modes.found import Diagram, Spins, find_modes, response_of, span_of
from ..studies.modes.place import at_of
from ..studies.modes.state import States, read_spec

# Modes as a table for the screen.

_SHARE = 0.05  # of the energy, from which a body is named
_COLUMNS = 8  # branches on the screen
_BODIES = 3  # named for a mode


def modes_text(content: dict[str, Any], count: int) -> str:
    """Return the table of modes of the content of modes.json."""
    modes, axes = content["modes"], ""
    if content["spin"] is not None and (speed := content["spin"]["speed"]):
        x, y, z = content["spin"]["axis"]
        axes = f", in axes that turn at {speed:.6g} rad/s about ({x:.3g}, {y:.3g}, {z:.3g})"
    title = f"{content['case']}, run {content['run']}: modes about {content['state']}{axes}"
    whirl = any(m["fixed_axes_angular_frequency"] is not None for m in modes)
    head = ["mode", "frequency", "", "damping", "fixed axes", "main coordinate", "bodies"]
    units = ["", "[Hz]", "[rad/s]", "[-]", "[rad/s]", "", "share of kinetic energy"]
    rows = []
    for m in modes:
        w = m["fixed_axes_angular_frequency"]
        seen = "" if w is None else f"{w:+.7g}"
        rows.append([str(m["number"]), *_numbers(m), seen, m["main"], _bodies(m)])
    table = [head, units, *rows[:count]]
    if not whirl:
        table = [row[:4] + row[5:] for row in table]
    left = tuple(range(len(table[0]) - 2, len(table[0])))
    lines = [title, "", aligned(table, left=left)]
    if len(rows) > count:
        lines.append(f"... and {len(rows) - count} more, see modes.json")
    constraints = content["constraints"]["text"]
    lines += ["", f"{content['degrees_of_freedom']} degrees of freedom; {constraints}"]
    if zeros := sum(m["kind"] == "zero" for m in modes):
        lines.append(f"{zeros} motions without stiffness: frequency 0")
    return "\n".join([*lines, *(f"note: {note}" for note in content["notes"])])


def campbell_text(content: dict[str, Any]) -> str:
    """Return the tables of a Campbell diagram of the content of campbell.json."""
    fixed = content["axes"] == "fixed"
    key = "fixed_axes_angular_frequency" if fixed else "angular_frequency"
    branches, speeds = content["branches"][:_COLUMNS], content["speeds"]
    table = [["speed", *(f"{b['branch']}" for b in branches)]]
    table.append(["[rad/s]", *("[Hz]" for _ in branches)])
    for s, speed in enumerate(speeds):
        cells = [(b[key][s], "*" if b["growth"][s] else "") for b in branches]
        hertz = ["-" if w is None else f"{abs(w) / (2.0 * pi):.6g}{star}" for w, star in cells]
        table.append([f"{speed:.6g}", *hertz])
    seen = "at rest" if fixed else "that turn with the mechanism"
    lines = [
        f"{content['case']}, run {content['run']}: frequencies seen from axes {seen}",
        "",
        aligned(table, left=()),
        "",
        *(f"{b['branch']:4d}  {b['main']}" for b in branches),
    ]
    if len(content["branches"]) > _COLUMNS:
        lines.append(f"... {len(content['branches']) - _COLUMNS} more in campbell.csv")
    if any(g for b in branches for g in b["growth"]):
        lines.append("* unstable")
    table = [
        ["crossing", "branch", "speed", "", "frequency"],
        ["", "", "[rad/s]", "[1/min]", "[Hz]"],
    ]
    for x in content["crossings"]:
        hz = x["angular_frequency"] / (2.0 * pi)
        rates = [f"{x['speed']:.6g}", f"{x['rpm']:.6g}", f"{hz:.6g}"]
        table.append([f"{x['harmonic']}P", str(x["branch"]), *rates])
    crossings = aligned(table, left=()) if content["crossings"] else "no crossings with harmonics"
    return "\n".join([*lines, "", crossings, *(f"note: {note}" for note in content["notes"])])


def _numbers(mode: dict[str, Any]) -> list[str]:
    if mode["kind"] == "zero":
        return ["0", "0", "-"]
    if mode["kind"] == "real":
        rate = mode["eigenvalue"][0]
        return ["-", f"{rate:+.5g} 1/s", "-"]
    damping = mode["damping_ratio"]
    return [
        f"{mode['frequency_hz']:.6g}",
        f"{mode['angular_frequency']:.7g}",
        f"{damping:.4g}" if abs(damping) > 1e-9 else "0",
    ]


def _bodies(mode: dict[str, Any]) -> str:
    shares = sorted(mode["bodies"].items(), key=lambda item: -item[1])
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
        content = diagram.content()
        print(json_text(content) if options.json else campbell_text(content))
        files = write_campbell(folder, diagram)
    else:
        modes, response = find_modes(states, states.at(at, axis)), None
        if span is not None:
            response = response_of(modes, span, options.input, options.output)
        content = modes_content(states, modes)
        # First: figures can fail. JSON is alone on standard output.
        print(json_text(content) if options.json else modes_text(content, options.count))
        files = write_modes(folder, states, modes, options.shapes, response)
    if not options.json:
        print(f"{folder}: {', '.join(files)}")
    return 0
