"""Which case, which of its runs and sweeps, which folder: for all commands with a case file."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import InputError, few, nearest
from ...inputs.case.file import case_file, case_name

if TYPE_CHECKING:  # importing it takes 0.4 s, longer than a command with nothing to do
    from ...inputs.case.load import Case


def build_folder(file: Path, *, coarse: bool = False) -> Path:
    """Return build/<case>, or build/<case>-coarse, of a case file or the folder of one."""
    return Path("build") / (case_name(case_file(file)) + ("-coarse" if coarse else ""))


def chosen_runs(case: "Case", names: Sequence[str] | None) -> list[str]:
    """Return the runs asked for in the order of the case; all of them if none is named."""
    return _chosen(case, "--run", "run", names, case.runs) or list(case.runs)


def chosen_sweeps(case: "Case", names: Sequence[str] | None) -> list[str]:
    """Return the sweeps asked for in the order of the case."""
    return _chosen(case, "--sweep", "sweep", names, case.top.sweeps)


def chosen_run(case: "Case", name: str | None, *, only: bool = False) -> str:
    """Return the run asked for; if none is named the first one, or with `only` the only one."""
    if only and name is None and len(case.runs) > 1:
        raise InputError(f"--run: expected one of {few(case.runs)}")
    return chosen_runs(case, None if name is None else [name])[0]


def _chosen(
    case: "Case", option: str, kind: str, names: Sequence[str] | None, known: Iterable[str]
) -> list[str]:
    every = list(known)
    for name in names or ():
        if name not in every:
            hint = nearest(name, every)
            raise InputError(f"{option} {name}: {case.file} has no such {kind}{hint}")
    return [name for name in every if name in (names or ())]
