"""Start the preprocessor in the Python with FEniCSx and exchange lines of text with it."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import plymotion

from ...errors import InputError
from .interpreter import find_interpreter

Line = dict[str, Any]  # {"progress": text}, or an outcome as in preprocess/batch.py
# Variables of this process's MPI job, if any; a worker must not join it.
LAUNCHER = ("OMPI_", "PMI_", "PMIX_", "MPI_LOCAL")
# A worker is one process and starts no other ranks. Open MPI then needs neither its daemon nor
# networks; to start the one and look for the others takes it 0.4 s. Others ignore the variables.
ONE_RANK = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1"}


@contextmanager
def importable() -> Iterator[Path]:
    """A folder for PYTHONPATH that contains only `plymotion`.

    A checkout is such a folder. The folder of an installed package is not: its numpy is built
    for this Python. In this case, a folder with a link is created.
    """
    package = Path(plymotion.__file__).resolve().parent
    if (package.parent / "pyproject.toml").is_file():
        yield package.parent
        return
    with tempfile.TemporaryDirectory(prefix="plymotion-") as folder:
        link = Path(folder) / "plymotion"
        try:
            link.symlink_to(package, target_is_directory=True)
        except OSError:  # Windows, without permission to create links
            shutil.copytree(package, link)
        yield Path(folder)


def environment(folder: Path) -> dict[str, str]:
    """Environment for the other Python, without variables that refer to modules of this one."""
    variables = {
        key: value
        for key, value in os.environ.items()
        if key not in ("PYTHONHOME", "VIRTUAL_ENV") and not key.startswith(LAUNCHER)
    }
    paths = [str(folder), *filter(None, [variables.get("PYTHONPATH")])]
    variables["PYTHONPATH"] = os.pathsep.join(paths)
    variables |= ONE_RANK
    variables.setdefault("OPENBLAS_NUM_THREADS", "1")  # threads do not help with small matrices
    return variables


def compile_forms() -> str:
    """Compile what DOLFINx needs of all sections, shells and solids; say what was done.

    Raises
    ------
    InputError : the compilation fails.
    """
    try:
        command = [find_interpreter(), "-P", "-m", "plymotion.preprocess", "compile"]
    except InputError:
        return "no Python with FEniCSx found: nothing is compiled for DOLFINx"
    with importable() as folder:
        done = subprocess.run(command, env=environment(folder), capture_output=True, text=True)
    if done.returncode:
        raise InputError(f"compile: {done.stderr.strip()}")
    return done.stdout.strip()


class Preprocessor:
    """A preprocessor process that makes one file after the other.

    Parameters
    ----------
    python : the interpreter
    folder : folder that contains `plymotion`
    command : of the preprocessor that reads names from standard input: body, section, shell
    options : of the command
    """

    def __init__(self, python: str, folder: Path, command: str, options: Sequence[str]) -> None:
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  as long as the process
        # -P: modules of the current folder must not shadow installed ones. A new session:
        # Ctrl-C reaches only this process, which then ends the other.
        self._process = subprocess.Popen(
            [python, "-P", "-m", "plymotion.preprocess", command, "-", "--json", *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=environment(folder),
            text=True,
            encoding="utf-8",
            start_new_session=True,
        )

    def make(self, spec: Path, progress: Callable[[str], None]) -> Line | None:
        """Make one file and return the outcome; None if the process has ended before.

        Parameters
        ----------
        progress : called with each step
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with contextlib.suppress(BrokenPipeError):  # it has ended, and says no more
            self._process.stdin.write(f"{spec}\n")
            self._process.stdin.flush()
        for text in self._process.stdout:
            line: Line = json.loads(text)
            if "progress" not in line:
                return line
            progress(line["progress"])
        return None

    def runs(self) -> bool:
        """Return whether the process has not ended."""
        return self._process.poll() is None

    def interrupt(self) -> None:
        """Interrupt the process; it removes its unfinished file."""
        self._signal(signal.SIGINT)

    def end(self, timeout: float) -> None:
        """Hand out no more work, wait for the process for `timeout` [s], then kill it."""
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            self._signal(signal.SIGKILL)
            self._process.wait()

    def _signal(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError):  # it has ended in the meantime
            os.killpg(self._process.pid, number)  # including its compiler processes, if any

    def exit_code(self) -> int:
        """Exit code of the process; negative: ended by that signal."""
        return self._process.wait()

    def end_reason(self) -> str:
        """Reason of its end: exit code or signal, and the last lines of its standard error."""
        code = self.exit_code()
        self._errors.seek(0)
        text = self._errors.read().decode("utf-8", "replace").strip()
        text = text.replace("error: ", "")
        how = f"killed by signal {-code}" if code < 0 else f"ended with code {code}"
        return "\n".join([how, *text.splitlines()[-5:]])
