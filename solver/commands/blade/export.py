"""Blade files of other codes: stiffness, mass and geometry for BeamDyn and HAWC2."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...errors import InputError, printable
from ...math.polylines import lengths_along
from ...package.common.temporary import write_text
from ..section.conventions import BLADE_AXES_LEADING_EDGE, transform
from ..section.results import SectionResults
from ..section.writers.blades import write_beamdyn, write_hawc2
from .body import line_of
from .stations import Station
from .windio import Blade


def write_for(code: str, blade: Blade, stations: Sequence[Station], folder: Path) -> list[Path]:
    """Write the files of a blade for another code; returns them.

    Parameters
    ----------
    code : one of OF_BLADES
    stations : from root to tip; those that have failed are left out

    Raises
    ------
    InputError : fewer than two complete stations.
    """
    found = [(s.r, s.results) for s in stations if s.results is not None]
    if len(found) < 2:
        raise InputError(f"blade: --to {code}: expected two complete stations or more")
    places, results = [r for r, _ in found], [one for _, one in found]
    writer = _beamdyn if code == "beamdyn" else _hawc2
    return writer(blade, places, results, folder)


def _beamdyn(
    blade: Blade, places: list[float], results: list[SectionResults], folder: Path
) -> list[Path]:
    """Matrices about the reference axis, and the key points of the primary input file."""
    points = line_of(blade, places)
    x, y, z = points.T
    file = write_beamdyn(
        folder / "blade_beamdyn.dat",
        lengths_along(points).tolist(),
        [one.K for one in results],
        [one.M for one in results],
        title=blade.file.stem,
        blade_axes=BLADE_AXES_LEADING_EDGE,
    )
    title = printable(blade.file.stem)
    lines = [
        f"          1   member_total    - Total number of members (-)  [{title}]",
        f"{len(x):11d}   kp_total        - Total number of key points (-) [must be at least 3]",
        f"     1 {len(x):4d}                 - Member number; Number of key points in this member",
        "\t\t kp_xr \t\t\t kp_yr \t\t\t kp_zr \t\t initial_twist",
        "\t\t  (m)  \t\t\t  (m)  \t\t\t  (m)  \t\t   (deg)",
    ]
    for r, *point in zip(places, z, -y, x, strict=True):
        lines.append("  ".join(f"{value: .10E}" for value in (*point, blade.twist.at(r))))
    keys = folder / "blade_beamdyn_geometry.dat"
    write_text(keys, "\n".join(lines) + "\n")
    return [file, keys]


def _hawc2(
    blade: Blade, places: list[float], results: list[SectionResults], folder: Path
) -> list[Path]:
    """Matrices about the half-chord line, and its c2_def: x to the leading edge, z to the tip."""
    to_middle = np.array(
        [[blade.offset.at(r) - 0.5 * blade.chord.at(r), blade.height.at(r)] for r in places]
    )
    twist = -np.radians([blade.twist.at(r) for r in places])
    c, s = np.cos(twist), np.sin(twist)
    middle = line_of(blade, places)
    middle[:, 1] += c * to_middle[:, 0] - s * to_middle[:, 1]
    middle[:, 2] += s * to_middle[:, 0] + c * to_middle[:, 1]
    file = write_hawc2(
        folder / "blade_hawc2_st.dat",
        lengths_along(middle).tolist(),
        [transform(one.K, d) for one, d in zip(results, to_middle, strict=True)],
        [transform(one.M, d, kind="mass") for one, d in zip(results, to_middle, strict=True)],
        title=blade.file.stem,
    )
    lines = ["begin c2_def ;", f"  nsec {len(places)} ;"]
    for k, (x, y, z) in enumerate(middle):
        values = " ".join(f"{value: .8e}" for value in (y, z, x, np.degrees(twist[k])))
        lines.append(f"  sec {k + 1} {values} ;")
    geometry = folder / "blade_hawc2_c2_def.htc"
    write_text(geometry, "\n".join([*lines, "end c2_def ;", ""]))
    return [file, geometry]
