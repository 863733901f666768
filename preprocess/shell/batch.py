"""Shell results files made by a batch."""

from pathlib import Path
from typing import Any

from ...solver.package.fingerprint import fingerprint
from ...solver.package.shell.io import write_shell
from ...solver.package.shell.schema import SHELL_FORMAT_VERSION, ShellFile
from ..analysed_files import AnalysedFiles


class ShellFiles(AnalysedFiles[ShellFile]):
    """Writes the results file of each shell; see `AnalysedFiles`."""

    def fingerprint(self, spec: dict[str, Any]) -> str:
        """Hash of all inputs of a shell file."""
        return fingerprint({"spec": spec, "format": list(SHELL_FORMAT_VERSION)})

    def analyse(self, spec: dict[str, Any], **team: Any) -> ShellFile:
        """Analyse the shell."""
        from .analysis import analyse  # here: FEniCSx is loaded only where something is built

        return analyse(spec, "shell", progress=self.progress, **team)

    def write(self, target: Path, result: ShellFile) -> None:
        """Write the shell file."""
        write_shell(target, result)
