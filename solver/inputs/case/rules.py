"""case.mk: what make must know of a case.

Neither make nor the shell can quote every path. A file that the case names is therefore listed
by a link of a plain name, which make follows to the file's time; no path of a case file is
in case.mk.
"""

import os
import re
from pathlib import Path
from typing import Any

from .load import Case
from .of_time import drives, law
from .output_folder import RULES_HEAD, OutputFolder
from .schema import Mechanism

_PLAIN = re.compile(r"[A-Za-z0-9_.][A-Za-z0-9_.,+@/-]*")
_UNUSABLE = (
    "$(error the folder of this file, or that of the case, has a name that make cannot read; "
    "expected letters, digits and . _ - + @)"
)


def rules(
    case: Case,
    folder: OutputFolder,
    body_specs: list[str],
    run_packages: list[Path],
    sweep_specs: dict[str, list[str]],
) -> str:
    """Return the text of case.mk: lists for the Makefile, and what the runs need.

    Parameters
    ----------
    folder : gets the links
    body_specs : files in `folder` from which make builds the packages of the runs
    run_packages : packages that the runs read
    sweep_specs : as body_specs, by sweep
    """
    base = os.path.relpath(folder.path)
    if not (_PLAIN.fullmatch(base) and _PLAIN.fullmatch(case.name)):
        return f"{RULES_HEAD}\n{_UNUSABLE}\n"

    def listed(names: list[str]) -> str:
        return " ".join(f"{base}/{name}" for name in names)

    text = [
        RULES_HEAD,
        f"{case.name}_SPECS := {listed(body_specs)}",
        f"{case.name}_RUNS := {' '.join(case.runs)}",
        f"{case.name}_SWEEPS := {' '.join(case.sweeps)}",
    ]
    for name, specs in sweep_specs.items():
        text.append(f"{case.name}_{name}_SPECS := {listed(specs)}")
    built = {folder.path / spec.replace(".json", ".vtkhdf"): spec for spec in body_specs}
    packages, foreign = [], []
    for package in dict.fromkeys(run_packages):
        if package in built:
            packages.append(built[package].replace(".json", ".vtkhdf"))
        else:
            foreign.append(folder.link(package))
    text.append(f"{base}/ran: {listed([f'runs/{run}.json' for run in case.runs] + packages)}")
    # A rule without a recipe: a file that is gone makes its readers anew, who tell its name.
    text += [f"{base}/ran: {base}/{link}\n{base}/{link}:" for link in foreign]
    for link in [folder.link(source) for source in _sources(case)]:
        text.append(f"{base}/case.mk: {base}/{link}\n{base}/{link}:")
    return "\n".join(text) + "\n"


def _sources(case: Case) -> list[Path]:
    """Return the files that the case is made from, apart from the case file."""
    mechanisms = [*case.runs.values(), *(s.base for s in case.sweeps.values())]
    bodies = [*case.bodies.values(), *(b for s in case.sweeps.values() for b in s.bodies)]
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
    tables = [each.table for each in laws if each is not None and each.table is not None]
    return [folder / table.file for table in tables if table.file is not None]
