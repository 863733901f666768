"""The case that `plymotion modes` works on: its run, with packages built if out of date."""

import tempfile
from pathlib import Path

from ...errors import InputError, PackageError, nearest
from ...inputs.case import load_case
from ...inputs.case.load import Case
from ...inputs.case.specs import write_case
from ...run.execution import read_run
from ...run.outcome import RunSpec
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
    if file.is_dir():
        file = file / "case.toml"
    case = load_case(file, coarse=coarse)
    name = _run_of(case, run)
    build = Path("build") / (case.name + ("-coarse" if coarse else ""))
    folder = packages or build / "bodies"
    with tempfile.TemporaryDirectory(prefix="plymotion-") as temporary:
        out = Path(temporary)
        write_case(case, out, folder)
        if packages is None:
            build_packages(specs_of(out, [name]), folder, quiet=quiet)
        try:
            return read_run(out / "runs" / f"{name}.json"), build
        except PackageError as error:
            raise PackageError(f"{error}; `make {case.name}` builds the packages") from None


def _run_of(case: Case, run: str | None) -> str:
    if run is None:
        return next(iter(case.runs))
    if run not in case.runs:
        raise InputError(f"--run {run}: {case.file} has no such run{nearest(run, case.runs)}")
    return run
