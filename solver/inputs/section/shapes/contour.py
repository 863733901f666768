"""Contours of airfoils, and their files."""

import re
from pathlib import Path
from typing import Any

from ....errors import InputError, nearest


def contour(source: Any) -> list[list[float]]:
    """Coordinates from the upper trailing edge around the nose to the lower one.

    `source` is a file, the name of one in meshes/airfoils, or the coordinates themselves in either
    direction. Files have two numbers per line, in Selig's order or in Lednicer's (both sides from
    the nose on); other lines are headings.

    Raises
    ------
    InputError
        No such file, or numbers that are not a closed contour of unit chord.
    """
    if isinstance(source, str | Path):
        path = _file(Path(source))
        name, blocks = str(path), _blocks(path)
    else:
        name, blocks = "the coordinates", [[[float(x), float(y)] for x, y in source]]
    if len(blocks) == 2 and blocks[0][0][0] < 0.5 and blocks[1][0][0] < 0.5:
        points = blocks[0][::-1] + blocks[1][blocks[1][0] == blocks[0][0] :]
    else:
        points = [point for block in blocks for point in block]
    x = [point[0] for point in points]
    if len(points) < 10 or not (min(x[0], x[-1]) > 0.9 and max(x) < 1.1 and -0.1 < min(x) < 0.1):
        raise InputError(
            f"contour: {name} holds {len(points)} points, expected at least 10, from the trailing "
            "edge (x = 1) around the nose (x = 0) and back"
        )
    area = sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(points, points[1:] + points, strict=False))
    return points if area > 0.0 else points[::-1]


def _file(path: Path) -> Path:
    if path.is_file():
        return path
    here = Path(__file__)
    for root in (here, here.resolve()):
        folder = root.parents[4] / "meshes" / "airfoils"
        if (folder / f"{path.name}.dat").is_file():
            return folder / f"{path.name}.dat"
        known = [file.stem for file in folder.glob("*.dat")]
    raise InputError(
        f'contour = "{path}": no such file, and none of the library{nearest(path.name, known)}'
    )


_PAIR = re.compile(r"^\s*([-+.\deE]+)[\s,]+([-+.\deE]+)\s*$")


def _blocks(path: Path) -> list[list[list[float]]]:
    """Blocks of lines with two numbers; a pair above 1.1 is Lednicer's number of points."""
    blocks: list[list[list[float]]] = [[]]
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        pair = _PAIR.match(line)
        try:
            point = [float(pair[1]), float(pair[2])] if pair else None
        except ValueError:
            point = None
        if point is None or max(map(abs, point)) > 1.5:
            blocks.append([])
        else:
            blocks[-1].append(point)
    return [block for block in blocks if block]
