"""The files that a case is made from, apart from the case file."""

from pathlib import Path
from typing import Any

from ..expressions.of_time import drives, law
from ..tables.schema import Mechanism
from .load import Case


def source_files(case: Case) -> list[Path]:
    """Return the files that runs and sweeps of a case read: descriptions, meshes, tables, code."""
    swept = [each for sweep in case.sweeps.values() for each in (sweep.own, *sweep.others.values())]
    mechanisms = [*case.runs.values(), *(members.base for members in swept)]
    bodies = [*case.bodies.values(), *(body for members in swept for body in members.bodies)]
    sources = {file for specs in bodies for spec in specs.values() for file in spec.sources}
    folder = case.file.parent
    sources |= {file for mechanism in mechanisms for file in _law_sources(mechanism, folder)}
    return sorted(sources)


def _law_sources(mechanism: Mechanism, folder: Path) -> list[Path]:
    """Return the files beside the case file that its laws of time come from."""
    laws: list[Any] = []
    for joint in mechanism.joints.values():
        laws += drives(joint).values()
    laws += [law(force) for force in mechanism.forces.values()]
    tables: list[Any] = [each.table for each in laws if each is not None]
    tables += mechanism.tables.values()
    tables += [getattr(force, "code", None) for force in mechanism.forces.values()]
    return [folder / t.file for t in tables if t is not None and t.file is not None]
