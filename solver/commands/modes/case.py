"""The case that `plymotion modes` works on: its run, with packages built if out of date."""

import tempfile
from pathlib import Path

from ...errors import InputError, PackageError
from ...inputs.case import load_case
from ...inputs.case.file import case_file
from ...inputs.case.specs import write_case
from ...run.execution import read_run
from ...run.outcome import RunSpec
from ..cases.chosen import build_folder, chosen_run
from ..cases.packages import build_packages, specs_of


def read_spec(
    file: Path, run: str | None, *, packages: Path | None, coarse: bool, quiet: bool
) -> tuple[RunSpec, Path]:
    """Return a run with its packages, and the folder build/<case> of its results.

    Parameters
    ----------
    file : cases/<name>/case.toml, or a run file build/<case>/runs/<run>.json
    run : name of the run; None: the only one, or the first
    packages : folder of ready packages; None: build/<case>/bodies, built there if out of date

    Raises
    ------
    InputError, PackageError
        An unknown run; what `check` and `run` find; packages that cannot be built.
    """
    if file.suffix == ".json":
        spec = read_run(file)
        if run is not None and run != spec.run:
            raise InputError(f"--run {run}: {file} is run {spec.run}; expected a case file")
        return spec, file.parent.parent
    file = case_file(file)
    case = load_case(file, coarse=coarse, sweeps=())
    name = chosen_run(case, run)
    build = build_folder(file, coarse=coarse)
    with tempfile.TemporaryDirectory(prefix="plymotion-") as temporary:
        out = Path(temporary)
        write_case(case, out, packages or build / "bodies")
        if packages is None:
            specs = specs_of(out, [name])
            build_packages(specs, build / "bodies", quiet=quiet)
        try:
            return read_run(out / "runs" / f"{name}.json"), build
        except PackageError as error:
            raise PackageError(f"{error}; `plymotion {file}` builds the packages") from None
