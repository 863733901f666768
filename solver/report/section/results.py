"""The beam properties in a section file, read without mesh, warping and recovery."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import PackageError
from ...math.arrays import Array
from ...package.common.container import open_file
from ...package.common.identity import check_provenance, checksum_findings, identity_notes
from ...package.common.remark import raise_first
from ...package.section.io import SECTION_FILE
from ...package.section.schema import SectionProperties


@dataclass(frozen=True, kw_only=True)
class SectionResults(SectionProperties):
    """The numbers of a section; lengths in m, forces in N."""

    @property
    def dofs(self) -> int:
        """Unknowns of the analysis."""
        return int(self.provenance.get("dofs", 0))

    @property
    def seconds(self) -> float:
        """Time of the analysis."""
        return float(self.provenance.get("seconds", 0.0))

    @property
    def refinements(self) -> list[dict[str, float]]:
        """Each with refine, dofs, error, seconds."""
        return list(self.provenance.get("refinements", []))

    @property
    def verification(self) -> str | None:
        """Outcome of `--verify`."""
        return self.provenance.get("verification")

    @property
    def scaled_error(self) -> Array | None:
        """The estimate in units of sqrt(K_ii K_jj), (6, 6) [-]."""
        if self.error_estimate is None:
            return None
        size = np.sqrt(np.diag(self.K))
        return np.asarray(self.error_estimate / np.outer(size, size))

    @property
    def worst_error(self) -> float | None:
        """Largest entry of `scaled_error`."""
        return None if self.scaled_error is None else float(np.max(self.scaled_error))


def read_results(file: Path) -> SectionResults:
    """Read the numbers of a section file. Raises PackageError for another or a damaged file."""
    with open_file(file, PackageError) as hdf:
        identity_notes(file, hdf, SECTION_FILE)
        raise_first(file, SECTION_FILE.layout_findings(hdf) + checksum_findings(hdf, SECTION_FILE))
        results = SECTION_FILE.load(hdf, SectionResults)
    check_provenance(file, results.provenance)
    return results
