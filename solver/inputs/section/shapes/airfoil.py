"""Skin along the contour of an airfoil, with webs; files of contours."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ....errors import InputError, nearest
from ....package.specification import LayerDirection, SectionMeshTable
from ...common.mesh_files import library
from .contract import DENSITY, Parameter, Plies, Shape, Values, Wall, size
from .parts import WEB, faces, rows, united


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
    folder = library("airfoils")
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


ROWS_SKIN = 2  # of a skin, thin for its length
SKIN: LayerDirection = {"curve": "outer"}


def walls(values: Mapping[str, Any]) -> tuple[Wall, ...]:
    """Regions by the number of webs."""
    webs = values.get("webs", ())
    n = len(webs) if isinstance(webs, list | tuple) else 1
    if n == 0:
        return (Wall("skin", SKIN, "skin"),)
    caps = [Wall(f"cap-{side}", SKIN, "cap") for side in ("upper", "lower")] if n > 1 else []
    each = [Wall(f"web-{i}", WEB.direction, "web") for i in range(1, n + 1)]
    rear = Wall("skin-rear", SKIN, "skin_rear")
    return (Wall("skin-front", SKIN, "skin"), *caps, rear, *each)


def mesh(values: Values, plies: Plies) -> SectionMeshTable:
    """Airfoil: rows of the skin at the depths of all its plies."""
    density, n_web = values["density"], len(values["webs"])
    webs = list(values["webs"])
    if webs != sorted(webs) or n_web > 3:
        raise InputError(f"webs = {webs}: expected up to three fractions, ascending")
    skin = values["skin"]
    if skin is None:
        raise InputError("skin: missing, expected the thickness of the skin [m]")
    thickness = {
        "skin_front": skin,
        "skin_rear": (values["skin_rear"] or skin) if n_web else skin,
        "cap": values["cap"] or skin,
    }
    web = values["web"] or [skin]
    if len(web) not in (1, n_web):
        raise InputError(f"web = {web}: expected one thickness, or one for each of {n_web} webs")
    depths = [
        [end * thickness[key] for end in rows(faces(plies[region]), ROWS_SKIN, density=density)]
        for region, key in (
            ("skin", "skin_front"),
            ("skin-front", "skin_front"),
            ("cap-upper", "cap"),
            ("cap-lower", "cap"),
            ("skin-rear", "skin_rear"),
        )
        if region in plies
    ]
    rows_web = {
        f"rows_web_{i}": rows(faces(plies[f"web-{i}"]), ROWS_SKIN, density=density)
        for i in range(1, n_web + 1)
    }
    return {
        "parameters": {
            "chord": values["chord"],
            "origin": values["origin"],
            **thickness,
            "webs": webs,
            "web": web * n_web if len(web) == 1 else web,
            "faces": united(depths, sorted(set(thickness.values()))),
            **rows_web,
            "density": density,
        },
        "coordinates": contour(values["contour"]),
    }


SHAPE = Shape(
    name="airfoil",
    script="airfoil",
    meaning="skin along an airfoil's contour with up to three webs; x2 from nose to tail. Before "
    "the point where the skins would meet, a wall as thick as the rear skin ends the section. "
    "Without webs its only region is `skin`; with one web there are no caps; the third web is "
    "`web-3`",
    parameters=(
        Parameter(
            "contour",
            "-",
            "file of coordinates (Selig or Lednicer), or a name in meshes/airfoils",
            required=True,
            text=True,
        ),
        size("chord", "chord length, unit of the contour", required=True),
        Parameter("origin", "-", "position of the origin, fraction of the chord", 0.0),
        size("skin", "thickness of the skin"),
        size("cap", "thickness of the skin between first and last web; default: skin"),
        size("skin_rear", "thickness of the skin behind the last web; default: skin"),
        Parameter(
            "webs",
            "-",
            "middles of the webs, fractions of the chord",
            (),
            above=0,
            most=1,
            many=True,
        ),
        size("web", "thickness of each web; one number: of all; default: skin", many=True),
        DENSITY,
    ),
    walls=(),
    mesh=mesh,
    walls_of=walls,
    example={"webs": [0.2, 0.5]},
    order=10,
)
