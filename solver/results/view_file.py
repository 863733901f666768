"""Views of bodies and joints as groups of result.vtkhdf: a dataset for each array."""

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..package.common.container import get_text, set_text
from .schema import ResultError
from .summary import plain
from .view import BodyView, Link, Side, Sites, Surface

# Unit and frame of each dataset of a view.
LAYOUT = {
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
PACKED = 50_000  # bytes above which an array is compressed
SURFACE = ("node", "offset_B", "triangles", "edges", "site")
SITES = ("place_B", "resultants_E", "kind", "compliance", "stress_M", "point_kind", "point_ply")
BODY = ("shapes_B", "stiffness", "frequencies", "centre_B")
SIDE = ("position_B", "A_BM", "phi_B", "psi_B")


def write_view(group: h5py.Group, view: BodyView) -> None:
    """Write the view of a body into its group."""
    group.attrs["first_position"] = view.first_position
    group.attrs["mass"] = view.mass
    set_text(group, "labels", json.dumps(view.labels))
    set_text(group, "provenance", json.dumps(plain(view.provenance)))
    for name in BODY:
        _put(group, name, getattr(view, name))
    for name in SURFACE:
        _put(group, f"surface/{name}", getattr(view.surface, name))
    if view.sites is not None:
        for name in SITES:
            _put(group, f"sites/{name}", getattr(view.sites, name))
        set_text(group["sites"], "plies", json.dumps(plain(view.sites.plies)))


def write_link(group: h5py.Group, link: Link) -> None:
    """Write a joint as attributes of its group: m, rad; axes as in results/view.py."""
    set_text(group, "kind", link.kind)
    set_text(group, "free", json.dumps(link.free))
    for number, side in enumerate(link.sides, 1):
        group.attrs[f"body_{number}"] = side.body
        for name in SIDE:
            group.attrs[f"{name}_{number}"] = getattr(side, name)


def read_view(path: Path, group: h5py.Group) -> BodyView | None:
    """Read the view of a body; None if its group has none. Raises ResultError."""
    if "shapes_B" not in group:
        return None
    with _told(path, group):
        sites = None
        if "sites" in group:
            plies = tuple(json.loads(get_text(group["sites"], "plies")))
            sites = Sites(**_arrays(group["sites"], SITES), plies=plies)
        surface = Surface(**_arrays(group["surface"], SURFACE))
        return BodyView(
            first_position=int(group.attrs["first_position"]),
            labels=tuple(json.loads(get_text(group, "labels"))),
            mass=float(group.attrs["mass"]),
            draw=lambda: surface,
            sites=sites,
            provenance=json.loads(get_text(group, "provenance")),
            **_arrays(group, BODY),
        )


def read_link(path: Path, group: h5py.Group) -> Link:
    """Read a joint. Raises ResultError."""
    with _told(path, group):
        one, two = (
            Side(
                int(group.attrs[f"body_{number}"]),
                *(np.asarray(group.attrs[f"{name}_{number}"]) for name in SIDE),
            )
            for number in (1, 2)
        )
        free = tuple(json.loads(get_text(group, "free") or "[]"))
        return Link(group.name.rsplit("/", 1)[1], get_text(group, "kind"), (one, two), free)


def _arrays(group: h5py.Group, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: np.asarray(group[name][()]) for name in names}


def _put(group: h5py.Group, name: str, values: Any) -> None:
    array = np.asarray(values)
    squeeze = {"compression": "gzip", "shuffle": True} if array.nbytes > PACKED else {}
    dataset = group.create_dataset(name, data=array, **squeeze)
    for key, word in zip(("unit", "frame"), LAYOUT[name], strict=False):
        set_text(dataset, key, word)


class _told:
    """Missing and damaged entries as ResultError with file and group."""

    def __init__(self, path: Path, group: h5py.Group) -> None:
        self.where = f"{path}: {group.name}"

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, KeyError | TypeError | ValueError):
            raise ResultError(f"{self.where}: damaged view: {error}") from error
