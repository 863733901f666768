"""sweep.h5: all results of a sweep in one file; the layout is in docs/sweeps.md."""

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ...math.arrays import Array
from ...package.common.container import as_text, get_text, new_file, open_file, set_text, text_array
from ...package.common.files import check_seal
from ...package.common.object_file import version_of
from ...package.common.plain_data import cell_text, csv_text
from ...results import ResultError
from ...results.summary import MEASURES
from ...run.preparation import output_times
from .sweep_members import SweepSpec

# What is kept of a member.

PENDING, FINISHED, STOPPED, FAILED = "pending", "finished", "stopped", "failed"
INTERRUPTED = "interrupted"
# Of some signals: Miner's sum of stresses with an S-N line, and error bars on request.
DAMAGE, ERROR_BAR = MORE = ("damage", "error_bar")
CHECKS = (
    "constraint_position_max",
    "constraint_rotation_max",
    "constraint_velocity_max",
    "energy_drift_relative",
    "drive_work",
)
COST = ("solve_s", "steps", "rejected", "evaluations", "jacobians", "factorisations")


@dataclass(frozen=True)
class Row:
    """What a sweep keeps of one member; empty tables where it has no results."""

    key: str
    status: str = PENDING  # pending, finished, stopped, failed
    message: str = ""
    code: str = ""
    t_end: float = np.nan  # [s]
    signals: dict[str, dict[str, Any]] = field(default_factory=dict)  # unit, MEASURES and MORE
    histories: dict[str, Array] = field(default_factory=dict)  # (n_t,), NaN after an early end
    checks: dict[str, float] = field(default_factory=dict)
    cost: dict[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()  # codes
    defect: str = ""  # traceback of an internal error; not stored in the file

    @property
    def done(self) -> bool:
        """Whether there is nothing left to compute."""
        return self.status != PENDING


# sweep.h5: all results of a sweep in one file; the layout is in docs/sweeps.md.

FILE, CSV = "sweep.h5", "sweep.csv"
FORMAT = "plymotion sweep"
FORMAT_VERSION = (1, 2)
TEXTS = ("key", "status", "message", "code", "warnings")
HEAD = ("case", "name", "title", "run", "design")
BLOCK = 10_000  # rows whose digests are computed together


@dataclass(frozen=True)
class SweepResult:
    """A sweep in memory: k members, p parameters; NaN where a member has no result."""

    case: str
    name: str
    title: str
    run: str
    design: str
    parameter_names: tuple[str, ...]  # (p)
    parameter_units: tuple[str, ...]
    values: Array  # (k, p)
    t: Array  # (n_t,) of the histories [s]
    signal_units: dict[str, str]
    signal_words: dict[str, str]  # descriptions
    rows: tuple[Row, ...]  # (k)

    def signal(self, name: str, measure: str) -> Array:
        """Return the one of MEASURES or MORE of a signal, (k,)."""
        return _column(row.signals.get(name, {}).get(measure) for row in self.rows)

    def numbers(self) -> Iterator[tuple[str, Array]]:
        """Yield the checks and costs of the members (k,), as "checks/NAME" and "cost/NAME"."""
        for group, names in (("checks", CHECKS), ("cost", COST)):
            for name in names:
                yield f"{group}/{name}", _column(getattr(r, group).get(name) for r in self.rows)

    def kept(self) -> list[str]:
        """Return the signals of which any row has a history."""
        return [n for n in self.signal_words if any(n in row.histories for row in self.rows)]

    def measures(self, name: str) -> tuple[str, ...]:
        """Return what there is of a signal."""
        known = {key for row in self.rows for key in row.signals.get(name, {})}
        return (*MEASURES, *(key for key in MORE if key in known))

    def history(self, name: str) -> Array:
        """Return a signal over time, (k, n_t)."""
        nothing = np.full(self.t.size, np.nan)
        return np.array([row.histories.get(name, nothing) for row in self.rows])

    def count(self, *states: str) -> int:
        """Return how many members have one of these states."""
        return sum(row.status in states for row in self.rows)


def result_of(sweep: SweepSpec, rows: Sequence[Row]) -> SweepResult:
    """Return the result of a plan so far."""
    solver, signals = sweep.mechanism.solver, sweep.mechanism.signals
    units = {n: s["unit"] for row in rows for n, s in row.signals.items()}
    return SweepResult(
        case=sweep.case,
        name=sweep.name,
        title=sweep.title,
        run=sweep.run,
        design=sweep.design,
        parameter_names=tuple(p.name for p in sweep.parameters),
        parameter_units=tuple(p.unit for p in sweep.parameters),
        values=np.array([m.values for m in sweep.members], dtype=float),
        t=output_times(solver.t_end, solver.output_step) if sweep.histories else np.zeros(0),
        signal_units={name: units.get(name, "") for name in sweep.signals},
        signal_words={
            n: signals[n].description for n in dict.fromkeys((*sweep.signals, *sweep.histories))
        },
        rows=tuple(rows),
    )


def write_sweep(path: Path, result: SweepResult) -> None:
    """Write sweep.h5; the file appears only when it is complete."""
    with new_file(path) as file:
        set_text(file, "format", FORMAT)
        file.attrs["format_version"] = np.array(FORMAT_VERSION, dtype=np.int64)
        for name in HEAD:
            set_text(file, {"name": "sweep"}.get(name, name), getattr(result, name))
        set_text(file, "units", "SI")
        file["parameters/name"] = text_array(result.parameter_names)
        file["parameters/unit"] = text_array(result.parameter_units)
        file["parameters/values"] = result.values
        for name in TEXTS:
            file[f"members/{name}"] = text_array([_text(row, name) for row in result.rows])
        file["members/sha256"] = text_array(_digests(result))
        file["members/t_end"] = np.array([row.t_end for row in result.rows])
        set_text(file["members/t_end"], "unit", "s")
        for name, values in result.numbers():
            file[name] = values
        for name, unit in result.signal_units.items():
            signal = file.create_group(f"signals/{name}")
            set_text(signal, "unit", unit)
            set_text(signal, "description", result.signal_words[name])
            for measure in result.measures(name):
                signal[measure] = result.signal(name, measure)
        if result.t.size:
            file["histories/t"] = result.t
            packed = {"compression": "gzip", "shuffle": True}
            for name in result.kept():
                key = f"histories/{name}"
                data = file.create_dataset(key, data=result.history(name), **packed)
                set_text(data, "description", result.signal_words[name])


def _digests(result: SweepResult) -> list[str]:
    """Return the digests of all that the file keeps of each row, every NaN the same.

    A restart computes rows with a wrong one again.
    """
    digests, signals, histories = [], sorted(result.signal_units), sorted(result.kept())
    for first in range(0, len(result.rows), BLOCK):
        block = replace(result, rows=result.rows[first : first + BLOCK])
        columns = [np.array([row.t_end for row in block.rows])]
        columns += [block.signal(name, measure) for name in signals for measure in MEASURES]
        columns += [values for _, values in block.numbers()]
        columns += [block.history(name) for name in histories]
        table = np.column_stack(columns).astype("<f8")
        table[np.isnan(table)] = np.nan
        for row, numbers in zip(block.rows, table, strict=True):
            texts = [row.key, row.status, row.message, row.code, *row.warnings]
            digest = hashlib.sha256("\0".join(texts).encode())
            digest.update(numbers.tobytes())
            digests.append(digest.hexdigest())
    return digests


def read_sweep(path: Path) -> SweepResult:
    """Read sweep.h5.

    Raises
    ------
    ResultError
        When the file is missing, truncated, foreign, newer, altered or incomplete.
    """
    return _read(path, whole=True)[0]


def believed_rows(path: Path) -> tuple[dict[str, Row], int]:
    """Return the completed rows of a file, altered or not, by key; and how many were altered.

    Raises
    ------
    ResultError
        As `read_sweep`, but for an altered file.
    """
    result, digests = _read(path, whole=False)
    believed = {
        row.key: row
        for row, digest, own in zip(result.rows, digests, _digests(result), strict=True)
        if row.done and own == digest
    }
    return believed, len(result.rows) - result.count(PENDING) - len(believed)


def _read(path: Path, *, whole: bool) -> tuple[SweepResult, list[str]]:
    """Return a sweep and the digests of its rows; `whole`: of an unaltered file only."""
    with open_file(path, ResultError) as file:
        major, minor = version_of(path, file, FORMAT, [FORMAT_VERSION[0]], ResultError)
        least = 1 if whole else FORMAT_VERSION[1]  # 1.0 has no checksums; rows have what they had
        if minor < least:
            raise ResultError(f"{path}: format {major}.{minor}: expected {major}.{least} or later")
        if whole:
            check_seal(path, ResultError)
        return _load(path, file), _words(file["members/sha256"])


def _load(path: Path, file: h5py.File) -> SweepResult:
    _check_lengths(path, file)
    signals, histories = file.get("signals", {}), file.get("histories", {})
    texts = [_words(file[f"members/{name}"]) for name in TEXTS]
    numbers = {
        group: {name: file[f"{group}/{name}"][()].tolist() for name in names}
        for group, names in (("checks", CHECKS), ("cost", COST))
    }
    measures = (*MEASURES, *MORE)
    measured = {n: {m: g[m][()].tolist() for m in measures if m in g} for n, g in signals.items()}
    units = {n: get_text(g, "unit") for n, g in signals.items()}
    series = {n: d[()] for n, d in histories.items() if n != "t"}
    rows = []
    ends = file["members/t_end"][()].tolist()
    for k, (key, status, message, code, codes) in enumerate(zip(*texts, strict=True)):
        row = Row(key, status, message, code, ends[k], warnings=tuple(codes.split()))
        if not np.isnan(ends[k]):
            row = replace(
                row,
                signals={
                    n: {"unit": units[n]}
                    | {m: None if v[k] != v[k] else v[k] for m, v in table.items()}
                    for n, table in measured.items()
                },
                histories={n: v[k] for n, v in series.items()},
                checks={n: v[k] for n, v in numbers["checks"].items()},
                cost={n: v[k] for n, v in numbers["cost"].items()},
            )
        rows.append(row)
    descriptions = {n: get_text(histories[n], "description") for n in series}
    descriptions |= {n: get_text(g, "description") for n, g in signals.items()}
    return SweepResult(
        **{n: get_text(file, {"name": "sweep"}.get(n, n)) for n in HEAD},
        parameter_names=tuple(_words(file["parameters/name"])),
        parameter_units=tuple(_words(file["parameters/unit"])),
        values=file["parameters/values"][()],
        t=histories["t"][()] if histories else np.zeros(0),
        signal_units=units,
        signal_words=descriptions,
        rows=tuple(rows),
    )


def _check_lengths(path: Path, file: h5py.File) -> None:
    """Raise ResultError for a dataset of another length or kind than the layout has."""
    lists = [file[name] for name in ("members/key", "parameters/name")]
    lists += [file["histories/t"]] if "histories" in file else []
    if any(not isinstance(item, h5py.Dataset) or item.ndim != 1 for item in lists):
        raise ResultError(f"{path}: members/key, parameters/name, histories/t: expected lists")
    k, p, n_t = [*(item.size for item in lists), 0][:3]
    expected = {"parameters/unit": (p,), "parameters/values": (k, p)}
    expected |= {"histories/t": (n_t,)} if n_t else {}
    for group in ("members", "checks", "cost", *(f"signals/{n}" for n in file.get("signals", ()))):
        expected |= {f"{group}/{name}": (k,) for name in file[group]}
    expected |= {f"histories/{n}": (k, n_t) for n in file.get("histories", ()) if n != "t"}
    text = {f"members/{name}" for name in (*TEXTS, "sha256")} | {"parameters/unit"}
    for name, shape in expected.items():
        item = file[name]
        if (
            not isinstance(item, h5py.Dataset)
            or item.shape != shape
            or (item.dtype.kind not in ("SO" if name in text else "fi"))
        ):
            what = "words" if name in text else "numbers"
            raise ResultError(f"{path}: {name}: expected a dataset of {what} of the shape {shape}")


def sweep_csv(result: SweepResult) -> str:
    """Return the table of a sweep: a line for each member, a head with units."""
    names = zip(result.parameter_names, result.parameter_units, strict=True)
    head = ["member", *(cell_text(f"{name} [{unit}]" if unit else name) for name, unit in names)]
    head += ["status", "code", "t_end [s]"]
    kept = {name: result.measures(name) for name in result.signal_units}  # looks at all rows
    for name, unit in result.signal_units.items():
        units = {"t_min": "s", "t_max": "s", DAMAGE: "-"}
        head += [f"{name} {m} [{units.get(m, unit)}]" for m in kept[name]]
    lines: list[list[Any]] = [[*head, *CHECKS, *COST, "warnings", "message"]]
    columns = [np.array([row.t_end for row in result.rows])]
    columns += [result.signal(name, measure) for name, known in kept.items() for measure in known]
    columns += [values for _, values in result.numbers()]
    table, values = np.column_stack(columns).tolist(), result.values.tolist()
    for k, (row, numbers) in enumerate(zip(result.rows, table, strict=True)):
        line = [k, *values[k], row.status, row.code, *("" if x != x else x for x in numbers)]
        lines.append([*line, " ".join(row.warnings), cell_text(row.message)])
    return csv_text(lines)


def _text(row: Row, name: str) -> str:
    return " ".join(row.warnings) if name == "warnings" else str(getattr(row, name))


def _column(values: Iterable[float | None]) -> Array:
    """Return numbers as an array, NaN for None."""
    return np.array(list(values), dtype=float)


def _words(dataset: h5py.Dataset) -> list[str]:
    return [as_text(word) for word in dataset[()]]
