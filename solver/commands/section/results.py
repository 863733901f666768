"""The beam properties in a section file, read without mesh, warping and recovery."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import PackageError
from ...math.arrays import Array
from ...package.common.container import get_text, open_file
from ...package.common.dataset import read_dataset
from ...package.common.identity import checksum_findings, identity_notes, json_table
from ...package.common.remark import raise_first
from ...package.section.checks import section_layout_findings
from ...package.section.layout import SECTION_FILE, SECTION_FILE_LAYOUT, SECTION_GROUP

_CENTRES = ("shear_centre", "tension_centre", "mass_centre")
_READ = (
    "K",
    "M",
    "error_estimate",
    "initial_curvature",
    *_CENTRES,
    "warnings/codes",
    "warnings/messages",
)


@dataclass(frozen=True)
class SectionResults:
    """The numbers of a section; lengths in m, forces in N."""

    name: str
    K: Array  # (6, 6) stiffness                                [N, N m, N m2]
    M: Array  # (6, 6) mass per length for [v1 v2 v3 w1 w2 w3]  [kg/m, kg, kg m]
    error_estimate: Array | None  # (6, 6) of K, in its units
    shear_centre: Array  # (2,) x2, x3                          [m]
    tension_centre: Array  # (2,)                               [m]
    mass_centre: Array  # (2,)                                  [m]
    warnings: tuple[dict[str, str], ...]  # {"code", "message"}
    dofs: int
    seconds: float  # time of the analysis
    refinements: list[dict[str, float]]  # refine, dofs, error, seconds of each step
    initial_curvature: Array | None = None  # (3,) k1, k2, k3; None: prismatic   [rad/m]
    verification: str | None = None  # outcome of `--verify`

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
        group = hdf[SECTION_GROUP]
        raise_first(file, section_layout_findings(group) + checksum_findings(hdf, SECTION_FILE))
        data: dict[str, Any] = {
            spec.path: read_dataset(group[spec.path], spec)
            for spec in SECTION_FILE_LAYOUT
            if spec.path in _READ and spec.path in group
        }
        provenance = json_table(f"{file}: provenance", get_text(hdf, "provenance", "{}"))
        warnings = zip(data["warnings/codes"], data["warnings/messages"], strict=True)
        return SectionResults(
            name=get_text(hdf, SECTION_FILE.title),
            K=data["K"],
            M=data["M"],
            error_estimate=data.get("error_estimate"),
            **{name: data[name] for name in _CENTRES},
            warnings=tuple({"code": code, "message": message} for code, message in warnings),
            dofs=int(provenance.get("dofs", 0)),
            seconds=float(provenance.get("seconds", 0.0)),
            initial_curvature=data.get("initial_curvature"),
            verification=provenance.get("verification"),
            refinements=list(provenance.get("refinements", [])),
        )
