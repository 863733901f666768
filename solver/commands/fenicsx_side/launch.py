"""Start the preprocessor in the Python that has FEniCSx, and talk to it line by line."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import plymotion

Line = dict[str, Any]  # {"progress": words}, or an outcome as preprocess/batch.py has it
# Of this process's MPI job, if it is in one: a worker is a process for itself.
LAUNCHER = ("OMPI_", "PMI_", "PMIX_", "MPI_LOCAL")
GRACE = 2.0  # s that an interrupted process has to tidy up


@contextmanager
def importable() -> Iterator[Path]:
    """A folder for PYTHONPATH that holds `plymotion` and nothing that the other Python has too.

    A checkout is one. The folder that an installed package lies in is not: its numpy is built
    for this Python, so a folder of a link is made.
    """
    package = Path(plymotion.__file__).resolve().parent
    if (package.parent / "pyproject.toml").is_file():
        yield package.parent
        return
    with tempfile.TemporaryDirectory(prefix="plymotion-") as folder:
        link = Path(folder) / "plymotion"
        try:
            link.symlink_to(package, target_is_directory=True)
        except OSError:  # Windows, without the right to make links
            shutil.copytree(package, link)
        yield Path(folder)


def environment(folder: Path) -> dict[str, str]:
    """Variables for the other Python: ours, without what would lead it to this one's modules."""
    variables = {
        key: value
        for key, value in os.environ.items()
        if key not in ("PYTHONHOME", "VIRTUAL_ENV") and not key.startswith(LAUNCHER)
    }
    paths = [str(folder), *filter(None, [variables.get("PYTHONPATH")])]
    variables["PYTHONPATH"] = os.pathsep.join(paths)
    variables.setdefault("OPENBLAS_NUM_THREADS", "1")  # threads of small matrices only spin
    return variables


class Worker:
    """A preprocessor that makes one file after the other.

    Parameters
    ----------
    python : the interpreter
    folder : where it finds `plymotion`
    command : of the preprocessor that reads names from standard input: section, shell
    options : of the command
    hear : called with (worker, line) from a thread of its own; line None: the process has ended
    """

    def __init__(
        self,
        python: str,
        folder: Path,
        command: str,
        options: Sequence[str],
        hear: "Callable[[Worker, Line | None], None]",
    ) -> None:
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  as long as the process
        # -P: modules of the current folder must not shadow what is installed. A session of its
        # own: Ctrl-C reaches this process only, which then ends the other.
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
        self._hear = hear
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def give(self, spec: Path) -> None:
        """Ask for one file."""
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # it has ended: the thread tells
            self._process.stdin.write(f"{spec}\n")
            self._process.stdin.flush()

    def dismiss(self) -> None:
        """No more work: the process ends by itself."""
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()

    def interrupt(self) -> None:
        """Stop what it is at; it removes its unfinished file."""
        self._signal(signal.SIGINT)

    def end(self, patience: float) -> None:
        """Wait for the process for `patience` [s], then kill it."""
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._signal(signal.SIGKILL)
            self._process.wait()
        self._thread.join()
        self._errors.close()

    def _signal(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError):  # it has ended meanwhile
            os.killpg(self._process.pid, number)  # with its compilers, if any

    def exit_code(self) -> int:
        """How the process has ended; negative: by that signal."""
        return self._process.wait()

    def last_words(self) -> str:
        """Why it ended: its code or signal, and the last lines of its standard error."""
        code = self.exit_code()
        self._errors.seek(0)
        text = self._errors.read().decode("utf-8", "replace").strip()
        text = text.replace("error: ", "")
        how = f"killed by signal {-code}" if code < 0 else f"ended with code {code}"
        return "\n".join([how, *text.splitlines()[-5:]])

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for text in self._process.stdout:
            self._hear(self, json.loads(text))
        self._hear(self, None)
