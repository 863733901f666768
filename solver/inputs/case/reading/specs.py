"""Write what the other stages read: body specifications, runs, sweeps.

    build/<case>/case.json              title, figures, runs
    build/<case>/bodies/<name>.json     one distinct body: what the preprocessor builds
    build/<case>/runs/<run>.json        one run: resolved mechanism and its packages
    build/<case>/sweeps/<name>.json     one sweep: its members, their bodies in sweeps/bodies
    build/<case>/manifest.json          which files of the folder `check` has written

A file is rewritten only when its content changes, so that no package is built again after an edit
that does not concern it.
"""

import json
import os
from pathlib import Path
from typing import Any

from ..bodies.body_specs import BodySpec
from ..bodies.rich import model_and_check
from ..sweep.sweep_members import CheckedSweep, Members
from ..sweep.sweep_table import Packages, sweep_content, with_fidelity
from ..tables.body_schema import PackageBody
from ..tables.combining import needed
from ..tables.record import seal
from ..tables.schema import Mechanism
from .load import Case
from .output_folder import WRITER, OutputFolder


def write_case(case: Case, out: Path, packages: Path | None = None) -> None:
    """Write all files of a checked case into `out`, and remove those that it no longer has.

    Files of sweeps whose members were not asked for stay as an earlier call has left them.

    Parameters
    ----------
    packages : folder of ready packages; None: out/bodies, built by the preprocessor

    Raises
    ------
    InputError
        `out` has files of the same names that `check` has not written; nothing is written.
    """
    folder = OutputFolder(out)
    files = _BodyFiles(case, folder, packages)
    for run, mechanism in case.runs.items():
        model, check = model_and_check(case.bodies[run])
        table = files.packages(mechanism, model, "bodies", run)
        of_check = files.packages(mechanism, check, "bodies", f"{run}.check") if check else {}
        others = {}
        for name in needed(mechanism.signals):
            other, specs = case.runs[name], model_and_check(case.bodies[name])[0]
            of_other = files.packages(other, specs, "bodies", name)
            others[name] = {
                "packages": of_other,
                "checked": seal(other),
                "mechanism": other.model_dump(),
            }
        content = {
            "case": case.name,
            "run": run,
            "title": case.top.runs[run].title or run,
            "packages": table,
            **({"check_packages": of_check} if of_check else {}),
            **({"other_runs": others} if others else {}),
            "checked": seal(mechanism),
            "mechanism": mechanism.model_dump(),
        }
        folder.add(f"runs/{run}.json", dump(content))
    for name, sweep in case.sweeps.items():
        folder.add(f"sweeps/{name}.json", dump(_sweep(case, name, sweep, files)))
    left = case.top.sweeps.keys() - case.sweeps.keys()
    if left:
        folder.keep("sweeps/bodies/", *(f"sweeps/{name}." for name in left))
    first = next(iter(case.runs.values()))
    content = {
        "written_by": WRITER,
        "case": case.name,
        "title": case.top.title,
        "runs": {n: r.title or n for n, r in case.top.runs.items()},
        "figures": {n: f.model_dump() for n, f in case.top.figures.items()},
        "signals": {n: s.model_dump() for n, s in first.signals.items()},
    }
    folder.add("case.json", dump(content))
    folder.write()


class _BodyFiles:
    """Specifications of distinct bodies, each written once however many mechanisms have it."""

    def __init__(self, case: Case, folder: OutputFolder, packages: Path | None) -> None:
        self.case, self.folder, self.ready = case, folder, packages
        self._known: dict[str, Path] = {}  # hash of the inputs -> package

    def packages(
        self, mechanism: Mechanism, specs: dict[str, BodySpec], folder: str, run: str = ""
    ) -> Packages:
        """Return the packages of the bodies of a mechanism: file from `out`, hash of its inputs.

        A body that is new gets a specification in `folder`, named after the run that has it
        first: readable, and shared by the others. Without a run it is named after its hash, so
        that members that come and go leave the others' packages alone.
        """
        table: Packages = {}
        out = self.folder.path
        for name, body in mechanism.bodies.items():
            if isinstance(body, PackageBody):
                file = (self.case.file.parent / body.package).resolve()
                table[name] = {"file": os.path.relpath(file, out)}
        for name, spec in specs.items():
            digest = spec.inputs_sha256
            if digest not in self._known:
                stem = f"{name}.{run or digest[:12]}"
                package = (self.ready or out / folder) / f"{stem}.vtkhdf"
                # Packages of this folder are kept, whoever names it.
                here = self.ready is None or self.ready.resolve() == (out / folder).resolve()
                built = (f"{folder}/{stem}.vtkhdf",) if here else ()
                text = dump({**spec.content, "inputs_sha256": digest})
                self.folder.add(f"{folder}/{stem}.json", text, *built)
                self._known[digest] = package
            file = self._known[digest]
            table[name] = {"file": os.path.relpath(file, out), "inputs_sha256": digest}
        return table


def _sweep(case: Case, name: str, sweep: CheckedSweep, files: _BodyFiles) -> dict[str, Any]:
    """Return the content of sweeps/<name>.json."""

    def packages(run: Members) -> list[Packages]:
        models = (model_and_check(bodies)[0] for bodies in run.bodies)
        return [files.packages(run.base, model, "sweeps/bodies") for model in models]

    tables = packages(sweep.own)
    others = {run: packages(members) for run, members in sweep.others.items()}
    content = sweep_content(case.name, name, sweep, tables, others)
    return with_fidelity(
        sweep, content, lambda specs: files.packages(sweep.base, specs, "sweeps/bodies")
    )


def dump(data: Any) -> str:
    """Return readable JSON."""
    return json.dumps(data, indent=2) + "\n"
