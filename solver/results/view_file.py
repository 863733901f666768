"""Views of bodies and joints as records of result.vtkhdf: a dataset for each array."""

import json
from typing import Any

import numpy as np

from ..package.common.dataset import build, field_values, layout
from .datasets import Record
from .schema import BodyGeometry, ResultError
from .summary import plain
from .view import BodyView, Link, Side, Sites, Surface

SURFACE, SITES = "surface/", "sites/"  # groups of a body
SPECS = (*layout(BodyGeometry), *layout(BodyView), *layout(Surface, SURFACE))
# Unit and frame of each dataset of a body, and a description if it has one.
LAYOUT = {s.path: tuple(filter(None, (s.unit, s.frame, s.text))) for s in SPECS}
SIDE = ("position_B", "A_BM", "phi_B", "psi_B")


def view_record(view: BodyView) -> Record:
    """Return what a file has of the view of a body."""
    found: dict[str, Any] = {
        "first_position": view.first_position,
        "mass": view.mass,
        "labels": json.dumps(view.labels),
        "provenance": json.dumps(plain(view.provenance)),
    }
    found |= field_values(view) | field_values(view.surface, SURFACE)
    if view.sites is not None:
        found["sites/plies"] = json.dumps(plain(view.sites.plies))
        found["sites/dimension"] = view.sites.dimension
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
        return build(BodyGeometry, record, name=name, view=_view(record))


def _view(record: Record) -> BodyView | None:
    """Return the view of a body; None if its record has none."""
    if "shapes_B" not in record:
        return None
    sites = None
    if "sites/kind" in record:
        plies = tuple(json.loads(record["sites/plies"]))
        shell = np.shape(record["sites/resultants_E"])[1] == 8  # of a file without the dimension
        dimension = int(record.get("sites/dimension", 2 if shell else 1))
        sites = build(Sites, record, SITES, plies=plies, dimension=dimension)
    surface = build(Surface, record, SURFACE)
    return build(
        BodyView,
        record,
        first_position=int(record["first_position"]),
        labels=tuple(json.loads(record["labels"])),
        mass=float(record["mass"]),
        draw=lambda: surface,
        sites=sites,
        provenance=json.loads(record["provenance"]),
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


class _told:
    """Missing and damaged entries as ResultError with file and group."""

    def __init__(self, where: str) -> None:
        self.where = where

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, KeyError | TypeError | ValueError):
            raise ResultError(f"{self.where}: damaged view: {error}") from error
