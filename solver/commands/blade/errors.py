"""Estimated errors of the frequencies of a blade: of its sections, stations and elements.

The clamped blade is computed again with another table or with fewer elements: with every second
station, with stiffnesses that are lower by the error estimate of the sections, and with half of the
elements. Errors of the elements fall with the square of their length, those of the stations about
linearly with their distance (docs/blade.md), because lay-up and shape change within a few of them.
"""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...inputs.case import load_case
from ...inputs.case.file import CASE_FILE
from ...inputs.case.specs import write_case
from ...math.arrays import Array
from ...package.body.io import read_package
from ...package.common.temporary import write_text
from ..cases.packages import build_packages, specs_of
from .body import body_csv
from .case import elements_of
from .stations import Station, complete
from .windio import Blade

AS_IT_IS, SECTIONS, STATIONS, ELEMENTS = "blade", "sections", "stations", "elements"
COUNT = 6
# Error over the change when half of the stations or elements are left out.
SHARES = {SECTIONS: 1.0, STATIONS: 1.5, ELEMENTS: 1.0 / 3.0}

BODY = """
[bodies.{name}]
kind = "beam"
table = "{name}.csv"
elements = {elements}
modes = [{{ kind = "lowest", count = {count} }}]
interfaces = {{ root = {{ at = "start" }} }}

[joints.{name}]
kind = "fixed"
between = ["ground.hub", "{name}.root"]
"""
HEAD = """\
format = 1
title = "Errors of frequencies"

[ground.hub]
position = [0.0, 0.0, 0.0]

[solver]
t_end = 1.0
output_step = 1.0

[runs.all]
"""


def frequencies_at_rest(
    blade: Blade, stations: Sequence[Station], *, quiet: bool
) -> tuple[Array, dict[str, Array]]:
    """Return the lowest frequencies [Hz] of the clamped blade, and their relative errors by cause.

    A cause that cannot be estimated is left out: of the sections without their estimates, of the
    stations if there are fewer than three.
    """
    known = complete(stations)
    elements = elements_of(len(known))
    tables = {AS_IT_IS: (known, elements), ELEMENTS: (known, elements // 2)}
    if softer := _softer(known):
        tables[SECTIONS] = (softer, elements)
    if len(known) > 2:
        fewer = [*known[:-1:2], known[-1]]
        tables[STATIONS] = (fewer, max(elements, 2 * (len(fewer) - 1)))
    found = _computed(blade, tables, quiet=quiet)
    own = found.pop(AS_IT_IS)
    errors = {name: SHARES[name] * np.abs(w / own - 1.0) for name, w in found.items()}
    return own, errors


def _softer(stations: Sequence[Station]) -> list[Station]:
    """The stations with K lowered by its estimate; none if one has no estimate."""
    found = []
    for station in stations:
        one = station.results
        if one is None or one.error_estimate is None:
            return []
        K = one.K - np.diag(np.diag(one.error_estimate))
        if np.linalg.eigvalsh(K)[0] <= 0.0:
            return []
        found.append(replace(station, results=replace(one, K=K)))
    return found


def _computed(
    blade: Blade, tables: Mapping[str, tuple[Sequence[Station], int]], *, quiet: bool
) -> dict[str, Array]:
    """Frequencies [Hz] of clamped beams by name."""
    with tempfile.TemporaryDirectory(prefix="plymotion-") as temporary:
        folder = Path(temporary)
        text = HEAD
        for name, (stations, elements) in tables.items():
            write_text(folder / f"{name}.csv", body_csv(blade, stations))
            text += BODY.format(name=name, elements=elements, count=COUNT)
        write_text(folder / CASE_FILE, text)
        write_case(load_case(folder / CASE_FILE), folder / "out")
        bodies = folder / "out" / "bodies"
        build_packages(specs_of(folder / "out", ["all"]), bodies, quiet=quiet)
        files = {name: next(bodies.glob(f"{name}*.vtkhdf")) for name in tables}
        return {
            name: read_package(file).frequencies[:COUNT] / (2.0 * np.pi)
            for name, file in files.items()
        }


def error_text(frequencies: Array, errors: dict[str, Array]) -> str:
    """Return the table that the screen shows."""
    names = [name for name in SHARES if name in errors]
    lines = [
        "Frequencies of the clamped blade at rest, and their estimated errors:",
        f"{'mode':>4}  {'[Hz]':>9}" + "".join(f"  {name:>9}" for name in names),
    ]
    for k, f in enumerate(frequencies):
        cells = "".join(f"  {100.0 * errors[name][k]:8.2g}%" for name in names)
        lines.append(f"{k + 1:4d}  {f:9.5g}{cells}")
    return "\n".join(lines)


def error_csv(frequencies: Array, errors: dict[str, Array]) -> str:
    """Return the same numbers as a file."""
    names = [name for name in SHARES if name in errors]
    lines = [",".join(["mode", "frequency_hz", *(f"error_{name}" for name in names)])]
    for k, f in enumerate(frequencies):
        values = (f, *(errors[name][k] for name in names))
        lines.append(",".join([str(k + 1), *(repr(float(v)) for v in values)]))
    return "\n".join([*lines, ""])
