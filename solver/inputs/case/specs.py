"""Write what the other stages read: body specifications, runs, make rules.

    build/<case>/case.json              title, figures, runs
    build/<case>/bodies/<name>.json     one distinct body: what the preprocessor builds
    build/<case>/runs/<run>.json        one run: resolved mechanism and its packages
    build/<case>/sweeps/<name>.json     one sweep: its members, their bodies in sweeps/bodies
    build/<case>/case.mk                what make must know

A file is rewritten only when its content changes, so that make rebuilds no
package after an edit that does not concern it.
"""

import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ...package.common.container import temporary_sibling
from .body_specs import BodySpec
from .load import Case
from .of_time import drives, law
from .record import seal
from .schema import Mechanism, PackageBody
from .sweep_members import CheckedSweep
from .sweep_table import sweep_content


def write_case(case: Case, out: Path, packages: Path | None = None) -> None:
    """Write all files of a checked case into `out`.

    Parameters
    ----------
    packages : folder of ready packages; None: out/bodies, built by the preprocessor
    """
    files = _BodyFiles(case, out, packages)
    run_packages: dict[str, list[str]] = {}
    for run, mechanism in case.runs.items():
        table = files.packages(mechanism, case.bodies[run], "bodies", run)
        run_packages[run] = sorted(os.path.relpath(out / t["file"]) for t in table.values())
        write_if_changed(
            out / "runs" / f"{run}.json",
            dump(
                {
                    "case": case.name,
                    "run": run,
                    "title": case.top.runs[run].title or run,
                    "packages": table,
                    "checked": seal(mechanism),
                    "mechanism": mechanism.model_dump(),
                }
            ),
        )
    spec_files = list(files.specs)
    sweep_specs: dict[str, list[Path]] = {}
    for name, sweep in case.sweeps.items():
        content, sweep_specs[name] = _sweep(case, name, sweep, files)
        write_if_changed(out / "sweeps" / f"{name}.json", dump(content))
    kept = {f.stem for f in files.specs if f.parent.parent.name == "sweeps"}
    _drop_stale(out / "sweeps" / "bodies", kept, (".json", ".vtkhdf"))
    _drop_stale(out / "sweeps", set(case.sweeps), (".json", ".built"))
    _drop_stale(out / "bodies", {f.stem for f in spec_files}, (".json", ".vtkhdf"))
    _drop_stale(out / "runs", set(case.runs), (".json",))
    first = next(iter(case.runs.values()))
    write_if_changed(
        out / "case.json",
        dump(
            {
                "case": case.name,
                "title": case.top.title,
                "runs": {n: r.title or n for n, r in case.top.runs.items()},
                "figures": {n: f.model_dump() for n, f in case.top.figures.items()},
                "signals": {n: s.model_dump() for n, s in first.signals.items()},
            }
        ),
    )
    _write_rules(case, out, spec_files, run_packages, sweep_specs, built=packages is None)


class _BodyFiles:
    """Specifications of distinct bodies, each written once however many mechanisms have it."""

    def __init__(self, case: Case, out: Path, packages: Path | None) -> None:
        self.case, self.out, self.ready = case, out, packages
        self.specs: list[Path] = []
        self._known: dict[str, tuple[Path, Path]] = {}  # hash -> specification, package

    def packages(
        self, mechanism: Mechanism, specs: dict[str, BodySpec], folder: str, run: str = ""
    ) -> dict[str, dict[str, str]]:
        """Return the packages of the bodies of a mechanism: file from `out`, hash of its inputs.

        A body that is new gets a specification in `folder`, named after the run that has it
        first: readable, and shared by the others. Without a run it is named after its hash, so
        that members that come and go leave the others' packages alone.
        """
        table: dict[str, dict[str, str]] = {}
        for name, body in mechanism.bodies.items():
            if isinstance(body, PackageBody):
                file = (self.case.file.parent / body.package).resolve()
                table[name] = {"file": os.path.relpath(file, self.out)}
            elif name in specs:
                digest = specs[name].inputs_sha256
                if digest not in self._known:
                    stem = f"{name}.{run or digest[:12]}"
                    file = self.out / folder / f"{stem}.json"
                    package = (self.ready or self.out / folder) / f"{stem}.vtkhdf"
                    write_if_changed(file, dump({**specs[name].content, "inputs_sha256": digest}))
                    self._known[digest] = file, package
                    self.specs.append(file)
                package = self._known[digest][1]
                table[name] = {
                    "file": os.path.relpath(package, self.out),
                    "inputs_sha256": digest,
                }
        return table

    def spec_files(self, digests: Iterable[str]) -> list[Path]:
        """Return the specifications of bodies."""
        return [self._known[digest][0] for digest in digests]


def _sweep(
    case: Case, name: str, sweep: CheckedSweep, files: _BodyFiles
) -> tuple[dict[str, Any], list[Path]]:
    """Return the content of sweeps/<name>.json, and the specifications of its bodies."""
    tables = [
        files.packages(member, bodies, "sweeps/bodies")
        for member, bodies in zip(sweep.members, sweep.bodies, strict=True)
    ]
    content = sweep_content(case.name, name, sweep, tables)
    digests = dict.fromkeys(
        t["inputs_sha256"] for table in tables for t in table.values() if "inputs_sha256" in t
    )
    return content, files.spec_files(digests)


def _write_rules(
    case: Case,
    out: Path,
    spec_files: list[Path],
    run_packages: dict[str, list[str]],
    sweep_specs: dict[str, list[Path]],
    *,
    built: bool,
) -> None:
    """Write case.mk: lists for the Makefile, and what the runs need."""
    base = os.path.relpath(out)
    text = [
        "# Written by `python -m plymotion.solver check`; do not edit.",
        f"{case.name}_SPECS := {' '.join(os.path.relpath(f) for f in spec_files) if built else ''}",
        f"{case.name}_RUNS := {' '.join(case.runs)}",
        f"{case.name}_SWEEPS := {' '.join(case.sweeps)}",
    ]
    for name, specs in sweep_specs.items() if built else ():
        text.append(f"{case.name}_{name}_SPECS := {' '.join(map(os.path.relpath, specs))}")
    run_files = [f"{base}/runs/{run}.json" for run in run_packages]
    needed = sorted({file for files in run_packages.values() for file in files})
    text.append(f"{base}/ran: {' '.join([*run_files, *needed])}")
    folder = case.file.parent
    mechanisms = [*case.runs.values(), *(s.base for s in case.sweeps.values())]
    bodies = [*case.bodies.values(), *(b for s in case.sweeps.values() for b in s.bodies)]
    sources = {file for specs in bodies for spec in specs.values() for file in spec.sources}
    sources |= {file for mechanism in mechanisms for file in _law_sources(mechanism, folder)}
    for file in sorted(os.path.relpath(source) for source in sources):
        # Its own rule has no recipe: a file that is gone makes the rules anew.
        text += [f"{base}/case.mk: {file}", f"{file}:"]
    # The rules file is the target of `check`: always newer than the case file.
    write_atomic(out / "case.mk", "\n".join(text) + "\n")


def _law_sources(mechanism: Mechanism, folder: Path) -> list[Path]:
    """Return the files beside the case file that its laws of time come from."""
    laws: list[Any] = []
    for joint in mechanism.joints.values():
        laws += drives(joint).values()
    laws += [law(force) for force in mechanism.forces.values()]
    tables: list[Any] = [each.table for each in laws if each is not None]
    tables += [getattr(force, "code", None) for force in mechanism.forces.values()]
    return [folder / t.file for t in tables if t is not None and t.file is not None]


def _drop_stale(folder: Path, keep: set[str], suffixes: tuple[str, ...]) -> None:
    """Remove files of bodies or runs that the case no longer has."""
    for file in folder.glob("*"):
        if file.suffix in suffixes and file.name[: -len(file.suffix)] not in keep:
            file.unlink()


def dump(data: Any) -> str:
    """Return readable JSON."""
    return json.dumps(data, indent=2) + "\n"


def write_if_changed(file: Path, text: str) -> None:
    """Write a file unless it already holds `text`."""
    if not (file.is_file() and file.read_text(encoding="utf-8") == text):
        write_atomic(file, text)


def write_atomic(file: Path, text: str) -> None:
    """Write to a temporary name in the same folder, then rename."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with temporary_sibling(file) as temporary:
        temporary.write_text(text, encoding="utf-8")
