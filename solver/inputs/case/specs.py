"""Write what the other stages read: body specifications, runs, make rules.

    build/<case>/case.json              title, figures, runs
    build/<case>/bodies/<name>.json     one distinct body: what the preprocessor builds
    build/<case>/runs/<run>.json        one run: resolved mechanism and its packages
    build/<case>/sweeps/<name>.json     one sweep: its members, their bodies in sweeps/bodies
    build/<case>/inputs/<digest>        links to the files that all this is made from
    build/<case>/case.mk                what make must know
    build/<case>/manifest.json          which files of the folder `check` has written

A file is rewritten only when its content changes, so that make rebuilds no
package after an edit that does not concern it.
"""

import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from .body_specs import BodySpec
from .combining import needed
from .load import Case
from .output_folder import OutputFolder
from .record import seal
from .rich import model_and_check
from .rules import rules
from .schema import Mechanism, PackageBody
from .sweep_members import CheckedSweep, Members
from .sweep_table import Packages, sweep_content


def write_case(case: Case, out: Path, packages: Path | None = None) -> None:
    """Write all files of a checked case into `out`, and remove those that it no longer has.

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
    run_packages: list[Path] = []
    for run, mechanism in case.runs.items():
        model, check = model_and_check(case.bodies[run])
        table = files.packages(mechanism, model, "bodies", run)
        of_check = files.packages(mechanism, check, "bodies", f"{run}.check") if check else {}
        run_packages += [out / t["file"] for t in (*table.values(), *of_check.values())]
        others = {}
        for name in needed(mechanism.signals):
            other, specs = case.runs[name], model_and_check(case.bodies[name])[0]
            of_other = files.packages(other, specs, "bodies", name)
            others[name] = {
                "packages": of_other,
                "checked": seal(other),
                "mechanism": other.model_dump(),
            }
            run_packages += [out / t["file"] for t in of_other.values()]
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
    body_specs = list(files.specs)
    sweep_specs: dict[str, list[str]] = {}
    for name, sweep in case.sweeps.items():
        content, sweep_specs[name] = _sweep(case, name, sweep, files)
        folder.add(f"sweeps/{name}.json", dump(content), f"sweeps/{name}.built")
    first = next(iter(case.runs.values()))
    content = {
        "case": case.name,
        "title": case.top.title,
        "runs": {n: r.title or n for n, r in case.top.runs.items()},
        "figures": {n: f.model_dump() for n, f in case.top.figures.items()},
        "signals": {n: s.model_dump() for n, s in first.signals.items()},
    }
    folder.add("case.json", dump(content))
    if packages is not None:
        body_specs, sweep_specs = [], {}
    text = rules(case, folder, body_specs, run_packages, sweep_specs)
    folder.write(last=("case.mk", text))


class _BodyFiles:
    """Specifications of distinct bodies, each written once however many mechanisms have it."""

    def __init__(self, case: Case, folder: OutputFolder, packages: Path | None) -> None:
        self.case, self.folder, self.ready = case, folder, packages
        self.specs: list[str] = []
        self._known: dict[str, tuple[str, Path]] = {}  # hash -> specification, package

    def packages(
        self, mechanism: Mechanism, specs: dict[str, BodySpec], folder: str, run: str = ""
    ) -> dict[str, dict[str, str]]:
        """Return the packages of the bodies of a mechanism: file from `out`, hash of its inputs.

        A body that is new gets a specification in `folder`, named after the run that has it
        first: readable, and shared by the others. Without a run it is named after its hash, so
        that members that come and go leave the others' packages alone.
        """
        table: dict[str, dict[str, str]] = {}
        out = self.folder.path
        for name, body in mechanism.bodies.items():
            if isinstance(body, PackageBody):
                file = (self.case.file.parent / body.package).resolve()
                table[name] = {"file": os.path.relpath(file, out)}
            elif name in specs:
                digest = specs[name].inputs_sha256
                if digest not in self._known:
                    stem = f"{name}.{run or digest[:12]}"
                    spec = f"{folder}/{stem}.json"
                    package = (self.ready or out / folder) / f"{stem}.vtkhdf"
                    # Packages of this folder are kept, whoever names it.
                    here = self.ready is None or self.ready.resolve() == (out / folder).resolve()
                    built = (f"{folder}/{stem}.vtkhdf",) if here else ()
                    text = dump({**specs[name].content, "inputs_sha256": digest})
                    self.folder.add(spec, text, *built)
                    self._known[digest] = spec, package
                    self.specs.append(spec)
                package = self._known[digest][1]
                table[name] = {
                    "file": os.path.relpath(package, out),
                    "inputs_sha256": digest,
                }
        return table

    def spec_files(self, digests: Iterable[str]) -> list[str]:
        """Return the specifications of bodies, from `out`."""
        return [self._known[digest][0] for digest in digests]


def _sweep(
    case: Case, name: str, sweep: CheckedSweep, files: _BodyFiles
) -> tuple[dict[str, Any], list[str]]:
    """Return the content of sweeps/<name>.json, and the specifications of its bodies."""

    def packages(members: Members) -> list[Packages]:
        pairs = zip(members.mechanisms, members.bodies, strict=True)
        return [files.packages(member, bodies, "sweeps/bodies") for member, bodies in pairs]

    tables = packages(sweep.own)
    others = {run: packages(members) for run, members in sweep.others.items()}
    content = sweep_content(case.name, name, sweep, tables, others)
    digests = dict.fromkeys(
        entry["inputs_sha256"]
        for table in (*tables, *(table for each in others.values() for table in each))
        for entry in table.values()
        if "inputs_sha256" in entry
    )
    return content, files.spec_files(digests)


def dump(data: Any) -> str:
    """Return readable JSON."""
    return json.dumps(data, indent=2) + "\n"
