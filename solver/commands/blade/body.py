"""The blade as a beam body: a table of its stations that the case of a mechanism reads.

Body axes: x along the pitch axis to the tip, y to the leading edge, z to the suction side, of a
section without twist; in windIO's axes z, -y and x.
"""

import csv
import io
from collections.abc import Sequence

import numpy as np

from ...inputs.case.beam_table import COLUMNS, TRAPEZE, UPPER
from ...math.arrays import Array
from ...package.section.io import read_section
from ...package.section.trapeze import trapeze_strains
from .stations import Station
from .windio import Blade

HEAD = """\
# Beam body of {name}, written by `plymotion blade`. In a case:
#   [bodies.blade]
#   kind = "beam"
#   table = "beam.csv"
# Body axes: x along the pitch axis to the tip, y to the leading edge, z to the suction side.
# Sections: x1 along the line, x2 to the leading edge, x3 to the suction side.
# K stiffness [N, N m, N m2] and M mass per length [kg/m, kg, kg m], both about the line.
# A1 ... A6: second-order strains of a twisted section (trapeze effect).
"""


def line_of(blade: Blade, places: Sequence[float]) -> Array:
    """Return points (n, 3) of the reference axis at r, in body axes [m]."""
    r = np.array(places)
    return np.column_stack(
        [blade.length.smooth(r), -blade.sweep.smooth(r), blade.prebend.smooth(r)]
    )


def body_csv(blade: Blade, stations: Sequence[Station]) -> str:
    """Return the table of a beam body from the complete stations.

    A positive twist of the file turns the leading edge to the pressure side, which is a negative
    rotation about x.
    """
    complete = [(s, s.results) for s in stations if s.results is not None]
    stream = io.StringIO(newline="")
    writer = csv.writer(stream)
    writer.writerow([*COLUMNS, *TRAPEZE])
    points = line_of(blade, [station.r for station, _ in complete])
    for (station, one), point in zip(complete, points, strict=True):
        row = [*point, -blade.twist.at(station.r)]
        row += [A[i, j] for A in (one.K, one.M) for i, j in UPPER]
        row += [*trapeze_strains(one.K, read_section(station.file).recovery)]
        writer.writerow([repr(float(value) + 0.0) for value in row])
    return HEAD.format(name=blade.file.name) + stream.getvalue()
