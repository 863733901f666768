"""Read a case file: merge variants, check every run, resolve names."""

from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ..errors import InputError, nearest
from ..input import lines, read_toml
from .check import cross_check
from .laws import FOLDER
from .schema import CaseFile, Mechanism


@dataclass(frozen=True)
class Case:
    """A checked case: its top and one mechanism per run."""

    name: str
    file: Path
    top: CaseFile
    runs: dict[str, Mechanism]


def load_case(file: Path, *, coarse: bool = False) -> Case:
    """Read and check a case file.

    Raises
    ------
    InputError
        Every finding on a line of its own: file, key, value, expectation.
    """
    table = read_toml(file, "case file")
    top_keys = set(CaseFile.model_fields)
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
    runs: dict[str, Mechanism] = {}
    for name, run in top.runs.items():
        merged = deepcopy(base)
        for variant in run.variants:
            if variant not in top.variants:
                problems.append(
                    f'{file}: runs.{name}.variants = "{variant}": '
                    f"no such variant{nearest(variant, top.variants)}"
                )
                continue
            merge(merged, top.variants[variant])
        if coarse:
            merge(merged, top.coarse)
        try:
            mechanism = Mechanism.model_validate(merged, context={FOLDER: file.parent})
        except ValidationError as error:
            problems += lines(error, Mechanism, str(file))
            continue
        problems += [f"{file}: {p}" for p in cross_check(mechanism, file.parent)]
        runs[name] = mechanism
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
    if problems:
        raise InputError("\n".join(dict.fromkeys(problems)))
    return Case(file.resolve().parent.name, file, top, runs)


def merge(base: dict[str, Any], over: dict[str, Any]) -> None:
    """Merge tables of `over` into `base` in place; values and lists are replaced."""
    for key, value in over.items():
        if isinstance(value, dict) and isinstance(base.get(key), dict):
            merge(base[key], value)
        else:
            base[key] = deepcopy(value)
