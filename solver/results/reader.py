"""Read the result of a run."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..errors import nearest
from ..package.common.container import get_text, kind_of_file, open_file
from ..package.common.identity import check_file_checksum, version_of
from .datasets import Record, read_array, read_record, read_table, read_texts
from .schema import (
    FORMAT,
    FORMAT_VERSION,
    TABLES_VERSION,
    ResultError,
    RunResult,
    Signal,
    check_result,
)
from .surfaces import drawn_by_views, positions_of_views
from .view_file import body_of, link_of


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
        if major > TABLES_VERSION[0]:
            raise ResultError(
                f"{path}: written by a newer Plymotion: format {major}.{minor}, "
                f"this reader knows {FORMAT_VERSION[0]}.x and {TABLES_VERSION[0]}.x"
            )
        result = _load(path, file)
        if (major, minor) > (1, 0):  # 1.0 had none
            check_file_checksum(path, file, ResultError)
        try:
            check_result(result)
        except ResultError as error:
            raise ResultError(f"{path}: /results/{error}") from None
    return result


def _load(path: Path, file: h5py.File) -> RunResult:
    group = _get(path, file, "results")

    def array(name: str) -> np.ndarray:
        return read_array(_get(path, group, name))

    def members(name: str) -> list[h5py.HLObject]:
        items = list(group[name].values()) if name in group else []
        return sorted(items, key=lambda item: int(item.attrs.get("index", 0)))

    def series(name: str) -> dict[str, np.ndarray]:
        return {item.name.rsplit("/", 1)[1]: read_array(item) for item in members(name)}

    def records(name: str) -> Iterator[tuple[str, str, Record]]:
        """Yield place in the file, name and record of bodies or joints."""
        if f"{name}_table" in group:
            where = f"{path}: /results/{name}_table"
            try:
                found = read_table(group[f"{name}_table"])
            except (KeyError, TypeError, ValueError) as error:
                raise ResultError(f"{where}: damaged table: {error}") from error
            yield from ((where, *each) for each in zip(*found, strict=True))
        for item in members(name):
            yield f"{path}: {item.name}", item.name.rsplit("/", 1)[1], read_record(item)

    def signals() -> tuple[Signal, ...]:
        if "signals_table" in group:
            table = group["signals_table"]
            words = (read_texts(_get(path, table, n)) for n in ("name", "unit", "description"))
            values = read_array(_get(path, table, "values"))
            return tuple(Signal(*each) for each in zip(*words, values, strict=True))
        return tuple(
            Signal(
                item.name.rsplit("/", 1)[1],
                get_text(item, "unit"),
                get_text(item, "description"),
                read_array(item),
            )
            for item in members("signals")
        )

    q = array("q")
    provenance = get_text(file, "provenance")
    if "provenance" in group:
        provenance = read_texts(group["provenance"])[0]
    bodies = tuple(body_of(*each) for each in records("bodies"))
    if "node_positions_G" not in group and drawn_by_views(bodies):
        nodes: Any = positions_of_views(q, bodies)
    else:
        nodes = array("node_positions_G")
    return RunResult(
        case=get_text(file, "case"),
        run=get_text(file, "run"),
        t=array("t"),
        signals=signals(),
        q=q,
        v=array("v"),
        multipliers=array("multipliers"),
        energies=series("energies"),
        bodies=bodies,
        node_positions_G=nodes,
        violations=series("violations"),
        node_deflection=array("node_deflection") if "node_deflection" in group else None,
        links=tuple(link_of(*each) for each in records("joints")),
        provenance=json.loads(provenance or "{}"),
    )


def _get(path: Path, group: h5py.Group, name: str) -> h5py.HLObject:
    if name not in group:
        raise ResultError(f"{path}: {group.name}: no {name!r}{nearest(name, group)}")
    return group[name]
