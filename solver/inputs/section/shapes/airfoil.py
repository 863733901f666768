"""Skin along the contour of an airfoil, with webs."""

from collections.abc import Mapping
from typing import Any

from ....errors import InputError
from ....package.specification import LayerDirection, SectionMeshTable
from .contour import contour
from .contract import DENSITY, Parameter, Plies, Shape, Values, Wall, size
from .spacing import faces, rows, united
from .walled import WEB

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
