"""result.vtkhdf: one file with an animation for ParaView and all result arrays."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..errors import nearest
from ..math.arrays import Array, IntArray, distinct
from ..math.rows import ComputedRows
from ..package.common.container import (
    MAX_ATTRIBUTE,
    get_text,
    new_file,
    open_file,
    set_numbers,
    set_text,
)
from ..package.common.dataset import field_values
from ..package.common.files import check_seal
from ..package.common.object_file import version_of
from ..package.common.plain_data import plain
from .datasets import (
    LAYOUT,
    MOST_GROUPS,
    MOST_NAMED,
    Datasets,
    Record,
    body_of,
    link_of,
    link_record,
    loads_of,
    read_array,
    read_record,
    read_table,
    read_texts,
    view_record,
    write_record,
    write_table,
    write_texts,
)
from .run_result import (
    FORMAT,
    FORMAT_VERSION,
    TABLES_VERSION,
    BodyGeometry,
    Derivative,
    ResultError,
    RunResult,
    Signal,
    check_result,
)
from .surfaces import MOST_STORED, drawn_by_views, positions_of_views

AT_ONCE = 6_000_000  # bytes of positions in memory, which do not grow with output times
MULTIPLIER_UNIT = "N, N m"


def write_result(
    path: str | Path,
    result: RunResult,
    *,
    max_frames: int = 200,
    all_positions: bool = False,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write result.vtkhdf under a temporary name, then rename it.

    /results has every output time. The animation has at most `max_frames` of
    them, including the first and the last. Positions of nodes that need more than
    100 MB are left out of /results unless `all_positions` is set: readers compute them from
    the coordinates (docs/adr/0044). `progress` is called with the part of /results that is written.

    Parameters
    ----------
    path : file, with the ending .vtkhdf
    result : the results of a run
    max_frames : largest number of times in the animation
    all_positions : positions of nodes are written whatever their size
    progress : function that gets the part of /results that is written, 0 to 1

    Raises
    ------
    ResultError
        Sizes disagree, or the name does not end in .vtkhdf.
    """
    path = Path(path)
    if path.suffix != ".vtkhdf":
        raise ResultError(f"{path}: expected a name that ends in .vtkhdf (ParaView requires this)")
    try:
        check_result(result)
    except ResultError as error:
        raise ResultError(f"{path}: {error}") from None
    # Written twice, computed once; an animation of all output times holds them in any case.
    if result.node_positions_G.nbytes <= AT_ONCE or len(result.t) <= max_frames:
        result = replace(result, node_positions_G=np.asarray(result.node_positions_G[:]))
    with new_file(path) as file:
        set_text(file, "format", FORMAT)
        many = max(len(result.bodies), len(result.links)) > MOST_GROUPS
        many |= len(result.signals) > MOST_NAMED
        version = TABLES_VERSION if many else FORMAT_VERSION
        set_numbers(file, "format_version", version)
        set_text(file, "case", result.case)
        set_text(file, "run", result.run)
        set_text(file, "units", "SI")
        group = file.create_group("results")
        provenance = json.dumps(plain(result.provenance, finite=True))
        if len(provenance.encode()) > MAX_ATTRIBUTE:
            write_texts(group, "provenance", [provenance])
        else:
            set_text(file, "provenance", provenance)
        _write_results(group, result, all_positions, progress)
        _write_sensitivities(file, result)
        chosen = frames(len(result.t), max_frames)
        deflection = None if result.node_deflection is None else result.node_deflection[chosen]
        points = result.node_positions_G[chosen]
        view = file.create_group("VTKHDF")
        write_animation(view, result.bodies, result.t[chosen], points, deflection)


def frames(k: int, max_frames: int) -> IntArray:
    """Select at most max_frames of k output times, evenly, including first and last."""
    return distinct(np.linspace(0, k - 1, max(1, min(k, max_frames))).round().astype(int))


def _write_results(
    group: h5py.Group,
    result: RunResult,
    all_positions: bool,
    progress: Callable[[float], None] | None,
) -> None:
    width = sum(array.shape[1] for array in (result.q, result.v, result.multipliers))
    width += len(result.energies) + len(result.violations) + len(result.signals) + 1
    datasets = Datasets(8 * width * len(result.t), progress)
    put = datasets.put
    put(group, "t", result.t, "s", "-", "output times")
    put(group, "q", result.q, "m, -, -", "G", "positions, Euler parameters, modal coordinates")
    put(group, "v", result.v, "m/s, rad/s, 1/s", "G, B", "velocities of bodies and modes")
    put(group, "multipliers", result.multipliers, MULTIPLIER_UNIT, "G", "Lagrange multipliers")
    for name, values in result.energies.items():
        put(group, f"energies/{name}", values, "J", "-", name.replace("_", " "))
    units = {"position": "m", "rotation": "rad", "velocity": "m/s"}
    for name, values in result.violations.items():
        text = f"largest constraint violation, {name}"
        put(group, f"violations/{name}", values, units.get(name, "-"), "-", text)
    if len(result.signals) > MOST_NAMED:
        _write_signals(group.create_group("signals_table"), result, datasets)
    for index, signal in enumerate(result.signals if len(result.signals) <= MOST_NAMED else ()):
        item = put(
            group, f"signals/{signal.name}", signal.values, signal.unit, "-", signal.description
        )
        set_numbers(item, "index", index)
    _write_records(group, "bodies", result.bodies, _body_record)
    _write_records(group, "joints", result.links, link_record)
    if result.loads is not None:
        record = {**field_values(result.loads), "names": json.dumps(result.loads.names)}
        write_record(group.create_group("loads"), record, LAYOUT)
    nodes = result.node_positions_G
    if all_positions or nodes.nbytes <= MOST_STORED or not drawn_by_views(result.bodies):
        text = "positions of all drawn points, bodies end to end"
        put(group, "node_positions_G", nodes, "m", "G", text)
    if result.node_deflection is not None:
        text = "magnitude of the elastic displacement"
        put(group, "node_deflection", result.node_deflection, "m", "B", text)


def _write_sensitivities(file: h5py.File, result: RunResult) -> None:
    datasets = Datasets()
    for index, one in enumerate(result.sensitivities):
        group, text = file.require_group(f"sensitivities/{one.signal}"), "derivative of the signal"
        item = datasets.put(group, one.parameter, one.values, one.unit, "-", text)
        item.attrs["index"], item.attrs["value"] = index, one.value


def _write_records(
    group: h5py.Group,
    name: str,
    items: Sequence[Any],
    record: Callable[[Any], Record],
) -> None:
    """Write bodies or joints: a group for each, or a table of many."""
    if len(items) > MOST_GROUPS:
        records = [record(item) for item in items]
        write_table(
            group.create_group(f"{name}_table"), [item.name for item in items], records, LAYOUT
        )
        return
    for index, item in enumerate(items):
        own = group.create_group(f"{name}/{item.name}")
        set_numbers(own, "index", index)
        write_record(own, record(item), LAYOUT)


def _body_record(body: BodyGeometry) -> Record:
    more = {} if body.view is None else view_record(body.view)
    return {**field_values(body), **more}


def _write_signals(group: h5py.Group, result: RunResult, datasets: Datasets) -> None:
    """Write many signals: names, units, descriptions (n,), values (n, k)."""
    signals = result.signals
    for text in ("name", "unit", "description"):
        write_texts(group, text, [getattr(signal, text) for signal in signals])
    rows = ComputedRows(
        (len(signals), len(result.t)),
        lambda first, end: np.array([np.asarray(s.values) for s in signals[first:end]]),
    )
    datasets.put(group, "values", rows, "of each signal", "-", "signals over time")


def write_animation(
    view: h5py.Group,
    bodies: Sequence[BodyGeometry],
    t: Array,
    points: Array,
    deflection: Array | None = None,
) -> None:
    """Write one unstructured grid of all bodies: fixed points and cells, moving displacement.

    Parameters
    ----------
    view : the group /VTKHDF of a new file
    t : (k,) times of the frames [s]
    points : (k, n, 3) global positions of the nodes of all bodies end to end [m]
    deflection : (k, n) magnitude of the elastic displacement [m]
    """
    n_step, n = points.shape[:2]
    starts = np.cumsum([0] + [len(body.nodes_B) for body in bodies])
    cells = [len(body.cell_types) for body in bodies]
    steps = write_grid(
        view,
        n,
        _join([b.connectivity + s for b, s in zip(bodies, starts[:-1], strict=True)]),
        np.concatenate([[0], np.cumsum(_join([np.diff(body.offsets) for body in bodies]))]),
        _join([body.cell_types for body in bodies]),
        dict(zip((body.name for body in bodies), cells, strict=True)),
        t,
        0,
    )
    view["Points"] = points[0]
    set_text(view["Points"], "unit", "m")
    moving = {"displacement": (points - points[0]).reshape(-1, 3)}
    if deflection is not None:
        moving["deflection"] = deflection.ravel()
    for name, values in moving.items():
        dataset = view.create_dataset(f"PointData/{name}", data=values)
        set_text(dataset, "unit", "m")
        steps[f"PointDataOffsets/{name}"] = np.arange(n_step, dtype=np.int64) * n


def write_grid(
    grid: h5py.Group,
    points: int,
    connectivity: IntArray,
    offsets: IntArray,
    types: IntArray,
    cells: Mapping[str, int],
    t: Array,
    stride: int,
) -> h5py.Group:
    """Write an unstructured grid of all bodies but its points and arrays; return its steps.

    Parameters
    ----------
    points : their number
    cells : number of cells of each body, by name
    t : (k,) times of the steps [s]
    stride : points that are further down in the file with each step; 0: they do not move
    """
    grid.attrs["Version"] = np.array([2, 2], dtype=np.int64)
    grid.attrs.create("Type", np.bytes_("UnstructuredGrid"), dtype="S16")
    grid["Connectivity"], grid["Offsets"] = connectivity, offsets.astype(np.int64)
    grid["Types"] = types.astype(np.uint8)
    counts = {"Points": points, "Cells": len(types), "ConnectivityIds": len(connectivity)}
    for name, count in counts.items():
        grid[f"NumberOf{name}"] = np.array([count], dtype=np.int64)
    grid["CellData/body_id"] = np.repeat(np.arange(len(cells)), [*cells.values()]).astype(np.int64)
    # As attributes: VTK 9.7 ends with a fault on texts in the field data of a file with time steps.
    # /results has the names of bodies that are too many for an attribute.
    if len(names := json.dumps([*cells])) <= MAX_ATTRIBUTE:
        set_text(grid["CellData/body_id"], "names", names)
    steps, each = grid.create_group("Steps"), np.arange(len(t), dtype=np.int64)
    steps.attrs["NSteps"] = np.int64(len(t))
    steps["Values"] = t
    set_text(steps["Values"], "unit", "s")
    steps["NumberOfParts"] = np.ones(len(t), dtype=np.int64)
    steps["PointOffsets"] = each * stride
    for name in ("PartOffsets", "CellDataOffsets/body_id"):
        steps[name] = 0 * each
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        steps[name] = 0 * each[:, None]
    return steps


def _join(parts: list[IntArray]) -> IntArray:
    return np.concatenate([np.zeros(0, dtype=np.int64), *parts]).astype(np.int64)


def read_result(path: str | Path) -> RunResult:
    """Read result.vtkhdf.

    Raises
    ------
    ResultError
        The file is missing, truncated, newer, incomplete or of another format.
    """
    path = Path(path)
    with open_file(path, ResultError) as file:
        majors = [FORMAT_VERSION[0], TABLES_VERSION[0]]
        version = version_of(path, file, FORMAT, majors, ResultError)
        result = _load(path, file)
        if version > (1, 0):  # 1.0 had none
            check_seal(path, ResultError)
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
                columns = read_table(group[f"{name}_table"])
            except (KeyError, TypeError, ValueError) as error:
                raise ResultError(f"{where}: damaged table: {error}") from error
            yield from ((where, *each) for each in zip(*columns, strict=True))
        for item in members(name):
            yield f"{path}: {item.name}", item.name.rsplit("/", 1)[1], read_record(item)

    def signals() -> tuple[Signal, ...]:
        if "signals_table" in group:
            table = group["signals_table"]
            texts = (read_texts(_get(path, table, n)) for n in ("name", "unit", "description"))
            values = read_array(_get(path, table, "values"))
            return tuple(Signal(*each) for each in zip(*texts, values, strict=True))
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
        loads=loads_of(f"{path}: /results/loads", read_record(group["loads"]))
        if "loads" in group
        else None,
        sensitivities=_sensitivities(file),
        provenance=json.loads(provenance or "{}"),
    )


def _sensitivities(file: h5py.File) -> tuple[Derivative, ...]:
    signals = file["sensitivities"].values() if "sensitivities" in file else ()
    items = sorted(
        (item for signal in signals for item in signal.values()),
        key=lambda item: int(item.attrs["index"]),
    )
    names = [item.name.rsplit("/", 2) for item in items]
    return tuple(
        Derivative(
            signal, parameter, get_text(item, "unit"), float(item.attrs["value"]), read_array(item)
        )
        for item, (_, signal, parameter) in zip(items, names, strict=True)
    )


def _get(path: Path, group: h5py.Group, name: str) -> h5py.HLObject:
    if name not in group:
        raise ResultError(f"{path}: {group.name}: no {name!r}{nearest(name, group)}")
    return group[name]
