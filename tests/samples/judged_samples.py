"""Runs whose findings are tested: each as a single run and as a member of a sweep."""

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from samples.case_samples import HEAD, SOLVER

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.package import ModalPackage, write_package
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.studies.sweep.portions import Packages, Row, compute
from plymotion.solver.studies.sweep.sweep_members import SweepSpec, read_sweep_spec

SWEEP = """
[sweeps.s]
run = "{run}"
[sweeps.s.vary]
"gravity.2" = [0.0]
"""


@dataclass(frozen=True)
class Judged:
    """A run twice."""

    summary: dict[str, Any]  # of the single run
    plan: SweepSpec  # of the sweep

    @cached_property
    def row(self) -> Row:
        """The member of the sweep, computed for tests that look at it or compare the codes."""
        (row,) = compute(self.plan, Packages(self.plan), [0], self.plan.keys())
        assert not row.defect, row.defect
        return row

    @property
    def codes(self) -> list[str]:
        """Codes of both, which must be the same, each once."""
        found = list(dict.fromkeys(w["code"] for w in self.summary["warnings"]))
        assert found == list(self.row.warnings)
        return found

    def finding(self, code: str) -> dict[str, Any]:
        """The only entry of a code in summary.json."""
        (entry,) = [w for w in self.summary["warnings"] if w["code"] == code]
        return entry


def judged(
    folder: Path,
    text: str,
    packages: dict[str, ModalPackage] | None = None,
    *,
    t_end: float = 1.0,
    step: float = 0.01,
    **solver: Any,
) -> Judged:
    """Run a case written as text; its bodies of packages lie beside it as NAME.vtkhdf."""
    for name, package in (packages or {}).items():
        write_package(folder / f"{name}.vtkhdf", package)
    file = folder / "case.toml"
    keys = {"gravity": "gravity = [0.0, 0.0, 0.0]\n" if "gravity" not in text else ""}
    plain = SOLVER.format(t_end=t_end, step=step, more="")
    own = {key: json.dumps(value) for key, value in solver.items()}
    lines = [line for line in plain.splitlines() if line.split(" =")[0] not in own]
    at = lines.index("[solver]") + 1
    lines[at:at] = [f"{key} = {value}" for key, value in own.items()]
    file.write_text(HEAD + keys["gravity"] + text + "\n".join(lines) + SWEEP.format(run="base"))
    return _twice(file, "base", None)


def judged_case(
    repository: Path, name: str, run: str, folder: Path, solver: dict[str, Any] | None = None
) -> Judged:
    """The same for a run of a case of the repository, with shipped packages."""
    text = (repository / "cases" / name / "case.toml").read_text()
    for words in ("[sweeps.", "# Sweeps:", "[coarse.sweeps"):
        text = text.split(words)[0]
    keys = "".join(f"{key} = {json.dumps(value)}\n" for key, value in (solver or {}).items())
    file = folder / "case.toml"
    more = f'variants = ["judged"]\n[variants.judged.solver]\n{keys}[sweeps.s.vary]'
    file.write_text(text + SWEEP.format(run=run).replace("[sweeps.s.vary]", more))
    return _twice(file, run, repository / "tests/packages" / name)


def _twice(file: Path, run: str, packages: Path | None) -> Judged:
    build = file.parent / "build"
    write_case(load_case(file), build, packages)
    plan = read_sweep_spec(build / "sweeps/s.json")
    # The mechanism of the sweep: variants of the sweep are not those of the run.
    table = json.loads((build / "runs" / f"{run}.json").read_text())
    table["mechanism"] = plan.mechanism_of(0).model_dump()
    single = build / "runs" / "judged.json"
    single.write_text(json.dumps(table))
    _, summary = execute(read_run(single), progress=False)
    return Judged(summary, plan)
