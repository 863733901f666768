"""Section files made by a batch."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...solver.package.fingerprint import fingerprint
from ...solver.package.section.io import write_section
from ...solver.package.section.schema import SECTION_FORMAT_VERSION, SectionFile
from ..analysed_files import AnalysedFiles, Ranks


class SectionFiles(AnalysedFiles[SectionFile]):
    """Writes the section file of each specification.

    Parameters
    ----------
    estimate, accuracy, verify : of `analyse`; they are inputs like the specification itself
    ranks, progress : see `AnalysedFiles`
    """

    def __init__(
        self,
        *,
        estimate: bool = True,
        accuracy: float | None = None,
        verify: bool = False,
        ranks: Ranks | None = None,
        progress: Callable[[str], None] | None = None,
    ) -> None:
        super().__init__(ranks, progress)
        self.estimate = estimate
        self.accuracy = accuracy
        self.verify = verify

    def fingerprint(self, spec: dict[str, Any]) -> str:
        """Hash of all inputs of a section file."""
        options = {"estimate": self.estimate, "accuracy": self.accuracy}
        if self.verify:
            options["verify"] = True
        version = list(SECTION_FORMAT_VERSION)
        return fingerprint({"spec": spec, "options": options, "format": version})

    def analyse(self, spec: dict[str, Any], **team: Any) -> SectionFile:
        """Analyse the section."""
        from .analysis import analyse  # here: FEniCSx is loaded only where something is built

        return analyse(
            spec,
            "section",  # the same for all sections: it is part of the key of a cached mesh
            estimate=self.estimate,
            accuracy=self.accuracy,
            verify=self.verify,
            progress=self.progress,
            **team,
        )

    def write(self, target: Path, result: SectionFile) -> None:
        """Write the section file."""
        write_section(target, result)
