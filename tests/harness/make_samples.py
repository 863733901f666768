"""A small project of its own in which make works on the cases of a test."""

import contextlib
import io
import os
import shutil
import subprocess
from pathlib import Path

from harness.hostile_profile import WAIT_S

from plymotion.solver.__main__ import main

DONE = [".venv/installed", "build/compiled", "build/fenicsx.env"]  # nothing is installed


class Project:
    """The Makefile and the sources of the repository, with own cases/ and build/."""

    def __init__(self, repository: Path, folder: Path) -> None:
        self.folder = folder
        folder.mkdir()
        shutil.copy(repository / "Makefile", folder)
        shutil.copytree(repository / "plymotion", folder / "plymotion")
        for name in ("solver", "preprocess", "meshes", "tools", "tests", ".venv"):
            (folder / name).symlink_to((repository / name).resolve())
        (folder / "cases").mkdir()
        (folder / "build").mkdir()
        environment = repository / "build/fenicsx.env"
        if environment.is_file():
            shutil.copy(environment, folder / "build")
        else:
            (folder / "build/fenicsx.env").write_text("FENICSX_PYTHON=/nowhere\n")

    def case(self, name: str, text: str, file: str = "case.toml") -> Path:
        """Write a file of a case; return its folder."""
        folder = self.folder / "cases" / name
        folder.mkdir(exist_ok=True)
        (folder / file).write_text(text, encoding="utf-8")
        return folder

    def make(self, *words: str, seconds: float = WAIT_S) -> subprocess.CompletedProcess[str]:
        """Run make without set-up, and runs in one process; what it prints is in stdout."""
        done = [word for file in DONE for word in ("-o", file)]
        environment = {k: v for k, v in os.environ.items() if not k.startswith("MAKE")}
        environment |= {"PYTHONPATH": str(self.folder), "PLYMOTION_COMPILED": "1"}
        return subprocess.run(
            ["make", "-j1", "JOBS=1", *done, *words],
            cwd=self.folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=seconds,
        )

    def again(self, *targets: str) -> str:
        """What the commands of targets print, in this process: make gives them each time."""
        with contextlib.chdir(self.folder), contextlib.redirect_stdout(io.StringIO()) as printed:
            for target in targets:
                case, _, sweep = target.partition("-sweep-")
                words = ["--sweep", sweep] if sweep else []
                assert main([f"cases/{case}/case.toml", *words, "--jobs", "1"]) == 0
        return printed.getvalue()
