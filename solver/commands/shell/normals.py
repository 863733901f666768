"""Where the normals e3 of the regions of a shell point, in words: plies start at the other side."""

import numpy as np

from ...math.arrays import Array
from ...package.shell.cells import centres
from ...package.shell.schema import ShellMeshData

ONE_WAY = 0.999  # length of the mean normal of a flat region
ALL = 1e-3  # share of the area that may point the other way
SHOWN = 6


def normal_lines(mesh: ShellMeshData) -> list[str]:
    """One line for each region, at most `SHOWN`."""
    places, e3 = centres(mesh.nodes_G, mesh.cells), mesh.A_GE[:, :, 2]
    lines = []
    for row, name in enumerate(mesh.regions[:SHOWN]):
        some = mesh.region == row
        if some.any():
            words = _direction(places[some], e3[some], mesh.area[some])
            lines.append(f"{'Normal e3':16}{name}: {words}")
    more = len(mesh.regions) - SHOWN
    return [*lines, f"{'':16}and {more} more"] if more > 0 else lines


def _direction(places: Array, e3: Array, area: Array) -> str:
    """Of cells with their centres (c, 3), normals (c, 3) and areas (c,)."""
    share = area / area.sum()
    mean = share @ e3
    if np.linalg.norm(mean) > ONE_WAY:
        return "({:.3g}, {:.3g}, {:.3g})".format(*(mean + 0.0).round(3))
    outwards = share[np.einsum("ci,ci->c", places - share @ places, e3) > 0.0].sum()
    if outwards > 1.0 - ALL:
        return "outwards, away from the middle of the region"
    if outwards < ALL:
        return "inwards, towards the middle of the region"
    return "varies; the file for ParaView has it"
