"""Read a case file: merge variants, check every run, resolve names."""

from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ...errors import InputError, nearest
from ..common import lines, read_toml
from .body_specs import BodySpec, BodySpecs
from .file import case_name
from .laws import FOLDER
from .parts import in_parts
from .schema import CaseFile, Mechanism
from .sweep_members import CheckedSweep, check_sweep

# Names that the folder of a case has for other things than the results of a run, or of a sweep.
RESERVED = {
    "runs": {
        "bodies": "a folder of this name",
        "runs": "a folder of this name",
        "sweeps": "a folder of this name",
    },
    "sweeps": {"bodies": "a folder sweeps/bodies"},
}

IN_COARSE = " (in [coarse])"


@dataclass(frozen=True)
class Case:
    """A checked case.

    Attributes
    ----------
    name : of its folder; of the file, unless that is case.toml
    file : where it comes from
    top : what is beside the mechanism
    runs : mechanism by run
    bodies : specifications of the flexible bodies by run and name
    sweeps : with all their members
    """

    name: str
    file: Path
    top: CaseFile
    runs: dict[str, Mechanism]
    bodies: dict[str, dict[str, BodySpec]]
    sweeps: dict[str, CheckedSweep] = field(default_factory=dict)


def load_case(file: Path, *, coarse: bool = False) -> Case:
    """Read and check a case file.

    Raises
    ------
    InputError
        One line per error: file, key, value, expectation.
    """
    table = read_toml(file, "case file")
    top_keys = set(CaseFile.model_fields)
    over = table.get("coarse")
    if coarse and isinstance(over, dict) and isinstance(over.get("sweeps"), dict):
        merge(table, {"sweeps": over["sweeps"]})
    try:
        top = CaseFile.model_validate({k: v for k, v in table.items() if k in top_keys})
    except ValidationError as error:
        raise InputError("\n".join(lines(error, CaseFile, str(file)))) from error
    base = {k: v for k, v in table.items() if k not in top_keys}
    for key in base:
        if key not in Mechanism.model_fields:
            known = [*CaseFile.model_fields, *Mechanism.model_fields]
            raise InputError(f"{file}: {key}: unknown key{nearest(key, known)}")
    problems: list[str] = []
    quick = {k: v for k, v in top.coarse.items() if k != "sweeps"} if coarse else {}

    def merged_with(key: str, variants: list[str]) -> dict[str, Any]:
        merged = deepcopy(base)
        for variant in variants:
            if variant not in top.variants:
                problems.append(
                    f'{file}: {key}.variants = "{variant}": '
                    f"no such variant{nearest(variant, top.variants)}"
                )
                continue
            merge(merged, top.variants[variant])
        merge(merged, quick)
        return merged

    specs = BodySpecs(file.parent)
    runs: dict[str, Mechanism] = {}
    bodies: dict[str, dict[str, BodySpec]] = {}
    if top.coarse and not coarse:
        problems += _of_coarse(file)
    problems += [
        f"{file}: {table}.{name}: expected another name, build/CASE has {RESERVED[table][name]}"
        for table, names in (("runs", top.runs), ("sweeps", top.sweeps))
        for name in RESERVED[table].keys() & names.keys()
    ]
    for name, run in top.runs.items():
        merged = merged_with(f"runs.{name}", run.variants)
        try:
            mechanism = Mechanism.model_validate(merged, context={FOLDER: file.parent})
        except ValidationError as error:
            problems += lines(error, Mechanism, str(file))
            continue
        runs[name], bodies[name], found = in_parts(mechanism, specs)
        problems += [f"{file}: {problem}" for problem in found]
    for name, figure in top.figures.items():
        for run_name in figure.runs:
            if run_name not in top.runs:
                problems.append(
                    f'{file}: figures.{name}.runs = "{run_name}": '
                    f"no such run{nearest(run_name, top.runs)}"
                )
        for mechanism in runs.values():
            if figure.signal not in mechanism.signals:
                problems.append(
                    f'{file}: figures.{name}.signal = "{figure.signal}": '
                    f"no such signal{nearest(figure.signal, mechanism.signals)}"
                )
    sweeps: dict[str, CheckedSweep] = {}
    for name, sweep in top.sweeps.items():
        key = f"sweeps.{name}"
        if sweep.run not in top.runs:
            hint = nearest(sweep.run, top.runs)
            problems.append(f'{file}: {key}.run = "{sweep.run}": no such run{hint}')
        elif sweep.run in runs:
            merged = merged_with(key, [*top.runs[sweep.run].variants, *sweep.variants])
            merged.pop("fidelity", None)  # members have the modes that the case gives
            checked = check_sweep(f"{file}: {key}", sweep, merged, specs)
            if isinstance(checked, list):
                problems += checked
            else:
                sweeps[name] = checked
    if problems:
        told = dict.fromkeys(problems)
        twice = {f"{line}{IN_COARSE}" for line in told}
        raise InputError("\n".join(line for line in told if line not in twice))
    return Case(case_name(file), file, top, runs, bodies, sweeps)


def _of_coarse(file: Path) -> list[str]:
    """Return what is wrong with a case in its coarse version, beyond the whole case."""
    try:
        load_case(file, coarse=True)
    except InputError as error:
        return [f"{line}{IN_COARSE}" for line in str(error).splitlines()]
    return []


def merge(base: dict[str, Any], over: dict[str, Any]) -> None:
    """Merge tables of `over` into `base` in place; values and lists are replaced."""
    for key, value in over.items():
        if isinstance(value, dict) and isinstance(base.get(key), dict):
            merge(base[key], value)
        else:
            base[key] = deepcopy(value)
