"""Views of bodies and joints as records of result.vtkhdf: a dataset for each array."""

import json
from typing import Any

import numpy as np

from .datasets import Record
from .schema import BodyGeometry, ResultError
from .summary import plain
from .view import BodyView, Link, Side, Sites, Surface

# Unit and frame of each dataset of a body, and a description.
LAYOUT: dict[str, tuple[str, ...]] = {
    "nodes_B": ("m", "B", "rest positions of the drawn points"),
    "connectivity": ("-", "-", "rows of nodes_B, cell by cell"),
    "offsets": ("-", "-", "start of each cell in connectivity"),
    "cell_types": ("-", "-", "VTK cell types"),
    "shapes_B": ("m, rad", "B"),  # translation and rotation of the nodes per unit mode
    "stiffness": ("N m", "-"),  # modal stiffness
    "frequencies": ("rad/s", "-"),  # natural circular frequency of each mode
    "centre_B": ("m", "B"),  # mass centre
    "surface/node": ("-", "-"),  # node of each point of the surface, as row of nodes_B
    "surface/offset_B": ("m", "B"),  # offset of each point from its node
    "surface/triangles": ("-", "-"),  # rows of points
    "surface/edges": ("-", "-"),  # sum of 1, 2, 4: edges 0-1, 1-2, 2-0 are drawn
    "surface/site": ("-", "-"),  # site at each corner, -1: none
    "sites/place_B": ("m", "B"),  # rest position of each site
    "sites/resultants_E": ("N, N m; N/m, N", "section or cell"),  # resultants per unit mode
    "sites/kind": ("-", "-"),  # section or laminate of each site, as row of compliance
    "sites/compliance": ("1/N, 1/(N m); m/N, 1/N", "section or cell"),  # strains per resultant
    "sites/stress_M": ("Pa per unit", "ply"),  # stress of the governing points per resultant
    "sites/point_kind": ("-", "-"),  # section or laminate of each point
    "sites/point_ply": ("-", "-"),  # ply of each point, as row of plies
}
GEOMETRY = ("nodes_B", "connectivity", "offsets", "cell_types")
SURFACE = ("node", "offset_B", "triangles", "edges", "site")
SITES = ("place_B", "resultants_E", "kind", "compliance", "stress_M", "point_kind", "point_ply")
BODY = ("shapes_B", "stiffness", "frequencies", "centre_B")
SIDE = ("position_B", "A_BM", "phi_B", "psi_B")


def view_record(view: BodyView) -> Record:
    """Return what a file has of the view of a body."""
    found: dict[str, Any] = {
        "first_position": view.first_position,
        "mass": view.mass,
        "labels": json.dumps(view.labels),
        "provenance": json.dumps(plain(view.provenance)),
    }
    found |= {name: getattr(view, name) for name in BODY}
    found |= {f"surface/{name}": getattr(view.surface, name) for name in SURFACE}
    if view.sites is not None:
        found |= {f"sites/{name}": getattr(view.sites, name) for name in SITES}
        found["sites/plies"] = json.dumps(plain(view.sites.plies))
    return found


def link_record(link: Link) -> Record:
    """Return what a file has of a joint: m, rad; axes as in results/view.py."""
    found: dict[str, Any] = {"kind": link.kind, "free": json.dumps(link.free)}
    for number, side in enumerate(link.sides, 1):
        found[f"body_{number}"] = side.body
        found |= {f"{name}_{number}": getattr(side, name) for name in SIDE}
    return found


def body_of(where: str, name: str, record: Record) -> BodyGeometry:
    """Return a body from its record. Raises ResultError."""
    with _told(where):
        return BodyGeometry(
            name=name,
            view=_view(record),
            **{key: np.asarray(record[key]) for key in GEOMETRY},
        )


def _view(record: Record) -> BodyView | None:
    """Return the view of a body; None if its record has none."""
    if "shapes_B" not in record:
        return None
    sites = None
    if "sites/kind" in record:
        plies = tuple(json.loads(record["sites/plies"]))
        sites = Sites(**_arrays(record, "sites/", SITES), plies=plies)
    surface = Surface(**_arrays(record, "surface/", SURFACE))
    return BodyView(
        first_position=int(record["first_position"]),
        labels=tuple(json.loads(record["labels"])),
        mass=float(record["mass"]),
        draw=lambda: surface,
        sites=sites,
        provenance=json.loads(record["provenance"]),
        **_arrays(record, "", BODY),
    )


def link_of(where: str, name: str, record: Record) -> Link:
    """Return a joint from its record. Raises ResultError."""
    with _told(where):
        one, two = (
            Side(
                int(record[f"body_{number}"]),
                *(np.asarray(record[f"{name}_{number}"]) for name in SIDE),
            )
            for number in (1, 2)
        )
        free = tuple(json.loads(record.get("free") or "[]"))
        return Link(name, str(record["kind"]), (one, two), free)


def _arrays(record: Record, group: str, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: np.asarray(record[f"{group}{name}"]) for name in names}


class _told:
    """Missing and damaged entries as ResultError with file and group."""

    def __init__(self, where: str) -> None:
        self.where = where

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, KeyError | TypeError | ValueError):
            raise ResultError(f"{self.where}: damaged view: {error}") from error
