"""Parameters by which a run is differentiated: numbers of its case, parameters of its `[design]`,
and those by which its packages have derivatives."""

import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...errors import InputError, few
from ...inputs.common.text_file import Tables
from ...math.arrays import Array
from ...run.inputs import RunSpec
from ..modes.state import spec_of_run
from ..sensitivities.parameters import (
    Parameter,
    combined,
    design_parameter,
    parameter_of,
    with_parameters,
    without_derivatives,
)
from .trials import BODIES, StudySpec, Trials

MANY = 50  # parameters of packages, above which they are combined
OF_DESIGN = "sensitivities"  # the study whose first design has the packages


def asked_of(
    table: dict[str, object],
    file: Path,
    run: str,
    keys: Sequence[str],
    build: Path,
    packages: Path | None,
    *,
    coarse: bool,
) -> tuple[RunSpec, list[Parameter], Sequence[str], Array | None]:
    """Return a run, its parameters, the keys of the derivatives, and shares.

    Many design parameters are replaced by fewer that change the packages in all ways that they do
    (`combined`). Shares (fewer, keys) then say what a parameter has of each key; None otherwise.

    Parameters
    ----------
    table, file : content of a case file, and its name for messages and relative paths
    run : name of the run
    keys : of numbers of the mechanism, names of `[design.parameters]`, or parameters of packages;
        none: all of `[design.parameters]` that are no choice
    build : folder of the case, where packages are built
    packages : folder of packages that are there already; None: they are built
    coarse : bodies have coarse meshes

    Raises
    ------
    InputError
        A key twice or none; a key that is no number, or has no derivative.
    """
    if twice := {key for key in keys if list(keys).count(key) > 1}:
        raise InputError(f"--of {few(twice)}: given twice")
    dotted = [key for key in keys if "." in key]
    case, members = with_parameters(table, file, run, dotted, coarse=coarse)
    design = case.top.design.parameters if case.top.design else {}
    known = [name for name, parameter in design.items() if parameter.kind != "choice"]
    keys = keys or known
    if not keys:
        raise InputError("--of: expected at least one key of a number, such as gravity.2")
    designed, shares = [key for key in keys if key in known], None
    if designed:
        spec, of_design = _of_design(table, file, run, designed, build, coarse=coarse)
    else:
        spec, of_design = spec_of_run(case, run, build, packages), []
    names = [key for key in keys if "." not in key and key not in known]
    if len(names) > MANY:
        for name in names:
            if not any(one.name == name for p in spec.packages.values() for one in p.design):
                raise without_derivatives(spec, name, known)
        kept, own = combined([spec], names)
        others = [*(member[0] for member in members), *designed]
        shares = np.zeros((len(others) + len(kept), len(keys)))
        for k, name in enumerate(others):
            shares[k, keys.index(name)] = 1.0
        shares[len(others) :, [keys.index(name) for name in names]] = own
        names = [names[k] for k in kept]
    numbers = [parameter_of(spec, *member) for member in members]
    parameters = [*numbers, *of_design, *(design_parameter(spec, name, known) for name in names)]
    if shares is None:
        parameters.sort(key=lambda parameter: keys.index(parameter.name))
    return spec, parameters, keys, shares


def _of_design(
    table: Tables, file: Path, run: str, names: list[str], build: Path, *, coarse: bool
) -> tuple[RunSpec, list[Parameter]]:
    """Return a run with packages that have derivatives, and its parameters of `[design]`."""
    study = {"run": run, "parameters": names, "minimise": {"mass": "mechanism"}, "rtol": 0.5}
    given = table["design"]
    design = {**given, "studies": {**given.get("studies", {}), OF_DESIGN: study}}
    folder = build / OF_DESIGN / run
    trials = Trials(StudySpec({**table, "design": design}, file, coarse, OF_DESIGN, folder))
    try:
        return trials.differentiable()
    finally:
        shutil.rmtree(folder / BODIES, ignore_errors=True)
