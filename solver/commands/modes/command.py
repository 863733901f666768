"""The command `plymotion modes`."""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...inputs.case.specs import dump
from ...math.arrays import Array
from ...package.common.replaceable import refuse_foreign
from ...package.common.temporary import write_text
from .campbell import Diagram, Spins
from .campbell_figure import draw
from .case import read_spec
from .export import write_linear
from .found import Found, entries, find_modes
from .place import at_of
from .response import response_of, span_of, write_response
from .shapes import draw_shapes
from .show import campbell_text, modes_text
from .state import States


def run_modes(options: argparse.Namespace) -> int:
    """Linearise a run about a state; return 0."""
    at = at_of(options.at)
    span = None if options.response is None else span_of(options.response)
    spec, build = read_spec(
        options.case,
        options.run,
        packages=options.packages,
        coarse=options.coarse,
        quiet=options.quiet,
    )
    folder: Path = options.out or build / "modes" / f"{spec.run}-{_label(options.at)}"
    axis = None if options.axis is None else np.array(options.axis)
    try:
        states = States(spec)
    except InputError as error:
        raise InputError(f"{options.case}, run {spec.run}: {error}") from error
    if at.kind == "spin" and at.speeds is not None and at.speeds.size > 1:
        return _campbell(options, states, at.speeds, axis, folder)
    found = find_modes(states, states.at(at, axis))
    content = modes_content(states, found)
    response = None
    if span is not None:
        response = response_of(found, span, options.input, options.output)
    refuse_foreign(folder / "modes.json")
    folder.mkdir(parents=True, exist_ok=True)
    write_linear(folder, states, found)
    files = ["modes.json", "linear.npz", "linear.mat"]
    if response is not None:
        write_response(folder, response)
        files += ["response.csv", "response.png"]
    files += draw_shapes(folder, states, found, options.shapes)
    write_text(folder / "modes.json", dump(content))
    if options.json:
        print(json.dumps(content, indent=2))
    else:
        print(modes_text(content, options.count))
        print(f"{folder}: {', '.join(files)}")
    return 0


def _campbell(
    options: argparse.Namespace, states: States, speeds: Array, axis: Array | None, folder: Path
) -> int:
    """Follow the modes over speed."""
    spins = Spins(states, axis)
    diagram = Diagram(spins, speeds, options.count, options.harmonics, options.axes)
    content = diagram.content()
    refuse_foreign(folder / "campbell.json")
    folder.mkdir(parents=True, exist_ok=True)
    draw(folder / "campbell.png", diagram)
    write_text(folder / "campbell.csv", diagram.csv())
    write_text(folder / "campbell.json", dump(content))
    print(json.dumps(content, indent=2) if options.json else campbell_text(content))
    if not options.json:
        print(f"{folder}: campbell.png, campbell.csv, campbell.json")
    return 0


def modes_content(states: States, found: Found) -> dict[str, Any]:
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
        "modes": entries(found, states.built.body_names),
        "notes": list(found.notes),
    }


def _label(text: str) -> str:
    """Return `--at` as part of a folder's name."""
    return text.replace("=", "").replace(":", "-")
