"""Write what the other stages read: body specifications, runs, sweeps.

    build/<case>/case.json              title, figures, runs
    build/<case>/bodies/<name>.json     one distinct body: what the preprocessor builds
    build/<case>/runs/<run>.json        one run: resolved mechanism and its packages
    build/<case>/sweeps/<name>.json     one sweep: its members, their bodies in sweeps/bodies
    build/<case>/manifest.json          which files of the folder `check` has written

A file is rewritten only when its content changes, so that no package is built again after an edit
that does not concern it.

manifest.json lists the files. It is written before the first file and after the last one is
gone, so that a `check` that was killed leaves no file that it does not know.
"""

import hashlib
import json
import os
import random
import re
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...package.common.files import kept_table, refuse_link, write_text
from .bodies.specifications import BodySpec, model_and_check
from .design import Case
from .record import needed, seal
from .sweeps import CheckedSweep, Members
from .tables.bodies import PackageBody
from .tables.schema import Mechanism

MANIFEST, CASE, WRITER = "manifest.json", "case.json", "plymotion check"
# What a manifest may name: anything else in it was written by somebody else. Earlier versions
# wrote rules for make and links to inputs, which are removed.
_OWN = re.compile(r"case\.json|case\.mk|((sweeps/)?bodies|runs|sweeps|inputs)/[A-Za-z0-9_.-]+")


class OutputFolder:
    """The files that `check` wants in a folder; nothing is written before `write`.

    Attributes
    ----------
    path : the folder
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._texts: dict[str, str] = {}
        self._made: dict[str, None] = {}  # by other programs, from these files
        self._kept: tuple[str, ...] = ()  # beginnings of names

    def add(self, name: str, text: str, *made: str) -> None:
        """Want a file; `made` are names of files that other programs make from it.

        Parameters
        ----------
        name : name of the file
        text : its content
        made : names of files that other programs make from it
        """
        self._texts[name] = text
        self._made |= dict.fromkeys(made)

    def keep(self, *beginnings: str) -> None:
        """Leave files of an earlier `check` whose names begin so as they are."""
        self._kept += beginnings

    def write(self) -> None:
        """Write all files and remove those of an earlier `check` that are not wanted or kept.

        Raises
        ------
        InputError
            The folder has a file of the same name that `check` has not written.
        """
        for name in (*self._texts, MANIFEST):
            refuse_link(self.path / name)
        before, adopted = self._before()
        wanted = [*self._texts, MANIFEST]
        for name in () if adopted else wanted:
            if name not in before and self._would_be_lost(name):
                raise InputError(
                    f"--out {self.path}: {name} already exists and was not written by `check`; "
                    "expected a new folder, or the build folder of a case"
                )
        made = [n for n in self._made if n in before or adopted or not (self.path / n).exists()]
        kept = [name for name in before if name.startswith(self._kept)]
        own = [*wanted, *made, *kept]
        self._record([*before, *own])
        for name, text in self._texts.items():
            write_if_changed(self.path / name, text)
        for name in before - set(own):
            (self.path / name).unlink(missing_ok=True)
        self._record(own)

    def _would_be_lost(self, name: str) -> bool:
        """Return whether a file has content that `write` would replace by another one."""
        file = self.path / name
        if not file.is_file():
            return file.is_symlink() or file.exists()
        return file.read_bytes() not in (b"", self._texts.get(name, "").encode())

    def _before(self) -> tuple[set[str], bool]:
        """Return the own files of an earlier `check`; whether one without manifest was here."""
        table = kept_table(self.path / MANIFEST)
        if table.get("written_by") == WRITER and isinstance(table.get("files"), list):
            own = {n for n in table["files"] if isinstance(n, str) and _is_own(n)}
            return {MANIFEST, *own}, False
        return set(), kept_table(self.path / CASE).get("written_by") == WRITER

    def _record(self, names: list[str]) -> None:
        table = {"written_by": WRITER, "files": sorted(set(names))}
        write_if_changed(self.path / MANIFEST, json.dumps(table, indent=1) + "\n")


def _is_own(name: str) -> bool:
    return _OWN.fullmatch(name) is not None and not name.endswith(("/.", "/.."))


def write_if_changed(file: Path, text: str) -> None:
    """Write a file unless it already holds `text`."""
    raw = text.encode("utf-8")
    if not (file.is_file() and file.read_bytes() == raw):
        write_text(file, text, own=True)


DRAWN = 3  # members at which the plan is checked
Packages = dict[str, dict[str, str]]  # file and hash of the inputs by body


def drawn_members(sweep: CheckedSweep) -> list[int]:
    """Return the numbers of members drawn at random; the same sweep always has the same."""
    fidelity = sweep.base.fidelity
    said = fidelity.model_dump() if fidelity is not None else None
    text = json.dumps([said, sweep.points.tolist(), sweep.table.vary], default=str)
    seed = hashlib.sha256(text.encode()).hexdigest()
    count = len(sweep.points)
    return sorted(random.Random(seed).sample(range(count), min(DRAWN, count)))


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
            "units": case.top.units,
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
        # Hash of the inputs -> own file, package from `out`, whether it asks for errors.
        self._known: dict[str, tuple[str, str, bool]] = {}

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
            digest, errors = spec.inputs_sha256, "errors" in spec.content
            if digest not in self._known:
                stem = f"{name}.{run or digest[:12]}"
                package = (self.ready or out / folder) / f"{stem}.vtkhdf"
                # Packages of this folder are kept, whoever names it.
                here = self.ready is None or self.ready.resolve() == (out / folder).resolve()
                built = (f"{folder}/{stem}.vtkhdf",) if here else ()
                self._add(f"{folder}/{stem}.json", spec, *built)
                self._known[digest] = f"{folder}/{stem}.json", os.path.relpath(package, out), errors
            own, built_file, asked = self._known[digest]
            if errors and not asked:  # as a later run does
                self._add(own, spec)
                self._known[digest] = own, built_file, True
            table[name] = {"file": built_file, "inputs_sha256": digest}
        return table

    def _add(self, file: str, spec: BodySpec, *built: str) -> None:
        """Add the file of a specification: once, as a sweep may have thousands of members."""
        text = dump({**spec.content, "inputs_sha256": spec.inputs_sha256})
        self.folder.add(file, text, *built)


def _sweep(case: Case, name: str, sweep: CheckedSweep, files: _BodyFiles) -> dict[str, object]:
    """Return the content of sweeps/<name>.json.

    A member is the mechanism with `changes` (dotted keys) and its own `packages`, given by their
    numbers in the list of all; `values` are those of the parameters. `other_runs` are those that
    combined signals read, with the same changes. Of a run with [fidelity], `base` and `base_check`
    are packages without changes, `drawn` has those of the check at some members.
    """
    numbers: dict[tuple[tuple[str, str], ...], int] = {}

    def numbered(run: Members, specs: dict[str, BodySpec]) -> dict[str, int]:
        return {
            body: numbers.setdefault(tuple(sorted(entry.items())), len(numbers))
            for body, entry in files.packages(run.base, specs, "sweeps/bodies").items()
        }

    def listed(run: Members) -> list[dict[str, object]]:
        return [
            {"changes": changes, "packages": numbered(run, model_and_check(bodies)[0])}
            for changes, bodies in zip(run.changes, run.bodies, strict=True)
        ]

    said, base = sweep.table, sweep.base
    own = listed(sweep.own)
    elsewhere = {run: listed(members) for run, members in sweep.others.items()}
    fidelity = {}
    if base.fidelity is not None:
        model, check = model_and_check(sweep.base_bodies)
        fidelity["fidelity"] = {
            "base": numbered(sweep.own, model),
            "base_check": numbered(sweep.own, check),
            "drawn": [
                {"member": k, "check": numbered(sweep.own, model_and_check(sweep.own.bodies[k])[1])}
                for k in drawn_members(sweep)
            ],
        }
    return {
        "case": case.name,
        "sweep": name,
        "title": said.title or name,
        "run": said.run,
        "design": said.design,
        "parameters": [{"name": p.name, "keys": p.keys, "unit": p.unit} for p in sweep.parameters],
        "signals": said.signals or list(base.signals),
        "histories": said.histories,
        "mechanism": base.model_dump(),
        "other_runs": {run: other.base.model_dump() for run, other in sweep.others.items()},
        "members": [
            {
                "values": values.tolist(),
                **member,
                "other_runs": {run: members[k] for run, members in elsewhere.items()},
            }
            for k, (values, member) in enumerate(zip(sweep.points, own, strict=True))
        ],
        "packages": [dict(entry) for entry in numbers],
        **fidelity,
    }


def dump(data: Any) -> str:
    """Return readable JSON."""
    return json.dumps(data, indent=2) + "\n"
