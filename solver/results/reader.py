"""Read the result of a run."""

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..errors import nearest
from ..package.common.container import get_text, kind_of_file, open_file
from ..package.common.identity import check_file_checksum, version_of
from .nodes import drawn_by_views, positions_of_views
from .schema import (
    FORMAT,
    FORMAT_VERSION,
    BodyGeometry,
    ResultError,
    RunResult,
    Signal,
    check_result,
)
from .view_file import read_link, read_view


def read_result(path: str | Path) -> RunResult:
    """Read result.vtkhdf.

    Raises
    ------
    ResultError
        The file is missing, truncated, newer, incomplete or of another format.
    """
    path = Path(path)
    with open_file(path, ResultError) as file:
        found = get_text(file, "format")
        if found != FORMAT:
            what = repr(found) if found else kind_of_file(file)
            raise ResultError(f"{path}: attribute format: expected {FORMAT!r}, this is {what}")
        major, minor = version_of(path, file, ResultError)
        if major > FORMAT_VERSION[0]:
            raise ResultError(
                f"{path}: written by a newer Plymotion: format {major}.{minor}, "
                f"this reader knows {FORMAT_VERSION[0]}.x"
            )
        result = _load(path, file)
        if minor > 0:  # 1.0 had none
            check_file_checksum(path, file, ResultError)
        try:
            check_result(result)
        except ResultError as error:
            raise ResultError(f"{path}: /results/{error}") from None
    return result


def _load(path: Path, file: h5py.File) -> RunResult:
    group = _get(path, file, "results")

    def array(name: str) -> np.ndarray:
        return np.asarray(_get(path, group, name)[()])

    def members(name: str) -> list[h5py.HLObject]:
        items = list(group[name].values()) if name in group else []
        return sorted(items, key=lambda item: int(item.attrs.get("index", 0)))

    def series(name: str) -> dict[str, np.ndarray]:
        return {item.name.rsplit("/", 1)[1]: item[()] for item in members(name)}

    q = array("q")
    bodies = tuple(_body(path, item) for item in members("bodies"))
    if "node_positions_G" not in group and drawn_by_views(bodies):
        nodes: Any = positions_of_views(q, bodies)
    else:
        nodes = array("node_positions_G")
    return RunResult(
        case=get_text(file, "case"),
        run=get_text(file, "run"),
        t=array("t"),
        signals=tuple(
            Signal(
                item.name.rsplit("/", 1)[1],
                get_text(item, "unit"),
                get_text(item, "description"),
                item[()],
            )
            for item in members("signals")
        ),
        q=q,
        v=array("v"),
        multipliers=array("multipliers"),
        energies=series("energies"),
        bodies=bodies,
        node_positions_G=nodes,
        violations=series("violations"),
        node_deflection=array("node_deflection") if "node_deflection" in group else None,
        links=tuple(read_link(path, item) for item in members("joints")),
        provenance=json.loads(get_text(file, "provenance") or "{}"),
    )


def _body(path: Path, item: h5py.Group) -> BodyGeometry:
    return BodyGeometry(
        name=item.name.rsplit("/", 1)[1],
        view=read_view(path, item),
        **{
            name: np.asarray(_get(path, item, name)[()])
            for name in ("nodes_B", "connectivity", "offsets", "cell_types")
        },
    )


def _get(path: Path, group: h5py.Group, name: str) -> h5py.HLObject:
    if name not in group:
        raise ResultError(f"{path}: {group.name}: no {name!r}{nearest(name, group)}")
    return group[name]
