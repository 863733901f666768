"""Write an FMU: description, library for this machine, run and packages, in one archive."""

import hashlib
import os
import platform
import re
import shlex
import subprocess
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path

from ....errors import InputError
from ....mechanism.building.python_functions import calling_forces
from ....package.common.temporary import temporary_sibling
from ....run.coupled import Stepper
from ....run.execution import read_run
from .contents import write_contents, write_inputs
from .description import description

LIBRARY = Path(__file__).with_name("library.c")
PLATFORMS = {
    ("Linux", "x86_64"): ("linux64", ".so"),
    ("Linux", "aarch64"): ("aarch64-linux", ".so"),
    ("Darwin", "x86_64"): ("darwin64", ".dylib"),
    ("Darwin", "arm64"): ("aarch64-darwin", ".dylib"),
}


def write_fmu(run_file: Path, out: Path, inputs: Sequence[str] | None = None) -> Stepper:
    """Write the FMU of a run file of `check`, whose packages are built.

    Parameters
    ----------
    inputs : names of drives and forces that are inputs; None: all

    Raises
    ------
    InputError
        No C compiler, another operating system, a run that cannot be made an FMU.
    """
    with tempfile.TemporaryDirectory(prefix="plymotion-") as name:
        folder = Path(name)
        resources = folder / "resources"
        run = write_contents(run_file, resources)
        spec = read_run(run)
        for name in calling_forces(spec.mechanism):
            raise InputError(
                f"forces.{name}.code: an FMU does not run Python files of the user; expected a "
                "controller or an expression"
            )
        stepper = Stepper(spec, inputs)
        write_inputs([given.name for given in stepper.inputs], resources)
        title = f"{spec.case}, {spec.run}"
        identifier = re.sub(r"\W", "_", f"{spec.case}_{spec.run}", flags=re.ASCII)
        identifier = identifier if identifier[0].isalpha() else f"m_{identifier}"
        solver = spec.mechanism.solver
        times = float(solver.t_end), float(solver.output_step)
        guid = _guid(resources)
        text = description(stepper, identifier, guid, title, times)
        (folder / "modelDescription.xml").write_bytes(text)
        _compile(folder / "binaries", identifier, guid)
        out.parent.mkdir(parents=True, exist_ok=True)
        with temporary_sibling(out) as temporary:
            _archive(folder, temporary)
    return stepper


def _guid(resources: Path) -> str:
    """Return a GUID that is the same for the same contents."""
    digest = hashlib.sha256()
    for file in sorted(path for path in resources.rglob("*") if path.is_file()):
        digest.update(file.relative_to(resources).as_posix().encode() + file.read_bytes())
    found = digest.hexdigest()
    return f"{{{found[:8]}-{found[8:12]}-{found[12:16]}-{found[16:20]}-{found[20:32]}}}"


def _compile(folder: Path, identifier: str, guid: str) -> None:
    machine = platform.system(), platform.machine()
    if machine not in PLATFORMS:
        known = ", ".join(" ".join(pair) for pair in PLATFORMS)
        raise InputError(f"--to fmu: {' '.join(machine)}: expected one of {known}")
    place, suffix = PLATFORMS[machine]
    target = folder / place / f"{identifier}{suffix}"
    target.parent.mkdir(parents=True)
    compiler = shlex.split(os.environ.get("CC") or "cc")
    options = ["-O2", "-shared", "-fPIC", "-fvisibility=hidden", "-D_GNU_SOURCE"]
    command = [*compiler, *options, f'-DGUID="{guid}"', str(LIBRARY), "-o", str(target), "-lm"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise InputError(
            f"--to fmu: {compiler[0]}: {error.strerror}; expected a C compiler, cc or that of "
            "the variable CC"
        ) from error
    if done.returncode != 0:
        raise InputError(f"--to fmu: {compiler[0]} fails: {done.stderr.strip()[-1000:]}")


def _archive(folder: Path, out: Path) -> None:
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(path for path in folder.rglob("*") if path.is_file()):
            archive.write(file, file.relative_to(folder).as_posix())
