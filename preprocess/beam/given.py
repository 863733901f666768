"""Sections of the stations of a beam: analysed, or given by their matrices."""

from typing import Any, NamedTuple

import numpy as np

from ...solver.math.arrays import Array
from ...solver.package.common.table_form import SpecError
from ...solver.package.section.schema import SectionFile, SectionRecovery
from ...solver.package.section.stress import trapeze_strains
from .line import LineSection
from .theory import section_stiffness

GIVEN = {"stiffness": (6, 6), "mass": (6, 6), "trapeze": (6,)}


class StationSection(NamedTuple):
    """Section of a station."""

    line: LineSection  # full stiffness and mass, trapeze strains of the beam's theory
    recovery: SectionRecovery | None  # None: given by its matrices
    dofs: int
    warnings: tuple[dict[str, str], ...]
    end_compliance: Array | None = None  # (6, 6) of a uniform beam, see SectionFile


def is_given(table: dict[str, Any]) -> bool:
    """True for a section with matrices instead of a mesh."""
    return not GIVEN.keys().isdisjoint(table)


def given_section(table: dict[str, Any]) -> StationSection:
    """Return a section from `stiffness`, `mass` and `trapeze`. Raises SpecError for other forms."""
    K, M, trapeze = (_numbers(table, key, shape) for key, shape in GIVEN.items())
    return StationSection(LineSection(K, M, trapeze), None, 0, ())


def analysed_section(result: SectionFile, theory: str) -> StationSection:
    """Return a section from its analysis."""
    trapeze = trapeze_strains(section_stiffness(result.K, theory), result.recovery)
    line = LineSection(result.K, result.M, trapeze)
    dofs, warnings = result.provenance["dofs"], tuple(result.warnings)
    return StationSection(line, result.recovery, dofs, warnings, result.end_compliance)


def _numbers(table: dict[str, Any], key: str, shape: tuple[int, ...]) -> Array:
    form = " x ".join(map(str, shape))
    try:
        found = np.array(table[key], dtype=float)
    except (KeyError, TypeError, ValueError) as error:
        raise SpecError(f"section.{key}: expected {form} numbers") from error
    if found.shape != shape or not np.isfinite(found).all():
        raise SpecError(f"section.{key}: expected {form} finite numbers")
    return found
