"""Sections along a beam: analysed or given at stations, linear between them; beam theories."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from ...solver.math.arrays import Array
from ...solver.math.laws import lengths_along
from ...solver.package.body.package_schema import SectionData
from ...solver.package.common.plain_data import SpecError
from ...solver.package.common.recovery_schema import SectionRecovery
from ...solver.package.section.section_schema import SectionFile
from ...solver.package.section.stress import trapeze_strains
from .line import BeamLine, LineSection

TINY = 1e-30  # imaginary step along derivatives of a section
_REMAINING_SHEAR = 1e-4  # per row and column: 1e-8 of the shear compliance is negligible


def of_theory(section: LineSection, theory: str) -> LineSection:
    """The section as a beam of this theory uses it."""
    if theory == "timoshenko":
        return section
    trapeze = section.trapeze.copy()
    trapeze[1:3] = 0.0
    return replace(section, K=section_stiffness(section.K, theory), trapeze=trapeze)


def section_stiffness(K: Array, theory: str) -> Array:
    """Return the 6x6 stiffness that a beam of this theory uses.

    "timoshenko" uses K unchanged. "classical" removes the shear compliance with its coupled
    entries. Extension, twist and bending keep their compliance; inertia does not change.

    The shear stiffness of a 6x6 follows from the energy of a constant shear force. In a wide
    strip with coupled bending and twist it also includes the energy of a changing twist. In
    vibration the shear force changes along the beam, and such a strip is then too soft.
    The classical theory is closer to a solid there (tests/fe/test_beam_solid.py).
    """
    if theory == "timoshenko":
        return K
    S = np.linalg.inv(K)
    S[1:3, :] *= _REMAINING_SHEAR
    S[:, 1:3] *= _REMAINING_SHEAR
    stiffness = np.linalg.inv(S)
    return 0.5 * (stiffness + stiffness.T)


GIVEN = {"stiffness": (6, 6), "mass": (6, 6), "trapeze": (6,)}


class StationSection(NamedTuple):
    """Section of a station."""

    line: LineSection  # full stiffness and mass, trapeze strains of the beam's theory
    recovery: SectionRecovery | None  # None: given by its matrices
    dofs: int
    warnings: tuple[dict[str, str], ...]
    end_compliance: Array | None = None  # (6, 6) of a uniform beam, see SectionFile
    error: Array | None = None  # (6, 6) expected size of the error of K, if it was asked for

    def stiffer(self) -> LineSection:
        """The section with a stiffness that has its expected error twice.

        K_ij (1 + r_i / 2 + r_j / 2), r the errors of the diagonal: definite, however K is coupled.
        """
        if self.error is None:
            return self.line
        d = np.sqrt(1.0 + np.diag(self.error) / np.diag(self.line.K))
        return replace(self.line, K=self.line.K * np.outer(d, d))


def is_given(table: dict[str, object]) -> bool:
    """True for a section with matrices instead of a mesh."""
    return not GIVEN.keys().isdisjoint(table)


def given_section(table: dict[str, object]) -> StationSection:
    """Return a section from `stiffness`, `mass` and `trapeze`. Raises SpecError for other forms."""
    K, M, trapeze = (_numbers(table, key, shape) for key, shape in GIVEN.items())
    return StationSection(LineSection(K, M, trapeze), None, 0, ())


def analysed_section(result: SectionFile, theory: str) -> StationSection:
    """Return a section from its analysis."""
    trapeze = trapeze_strains(section_stiffness(result.K, theory), result.recovery)
    line = LineSection(result.K, result.M, trapeze)
    dofs, warnings = result.provenance["dofs"], tuple(result.warnings)
    of_ends, error = result.end_compliance, result.error_estimate
    return StationSection(line, result.recovery, dofs, warnings, of_ends, error)


def line_rate(
    section: SectionFile, rates: Mapping[str, Array], theory: str, *, trapeze: bool
) -> LineSection:
    """Return the derivatives of what a beam is made of by a parameter of its section.

    Parameters
    ----------
    section : the analysis
    rates : of its arrays, by path
    theory : of the beam
    trapeze : with those of the trapeze strains, which depend on the strains of all points
    """
    K, M = (rates.get(path, np.zeros((6, 6))) for path in ("K", "M"))
    if not trapeze:
        return LineSection(K, M)

    def aside(path: str, value: Array) -> Array:
        return value + 1j * TINY * rates[path] if path in rates else value

    names, own = ("points", "weights", "A_BM", "strain_M"), section.recovery
    recovery: Any = SimpleNamespace(
        ply=own.ply,
        C_M=aside("plies/C_M", own.C_M),
        **{name: aside(f"recovery/{name}", getattr(own, name)) for name in names},
    )
    strains = trapeze_strains(section_stiffness(aside("K", section.K), theory), recovery)
    return LineSection(K, M, strains.imag / TINY)


def _numbers(table: dict[str, object], key: str, shape: tuple[int, ...]) -> Array:
    form = " x ".join(map(str, shape))
    try:
        values = np.array(table[key], dtype=float)
    except (KeyError, TypeError, ValueError) as error:
        raise SpecError(f"section.{key}: expected {form} numbers") from error
    if values.shape != shape or not np.isfinite(values).all():
        raise SpecError(f"section.{key}: expected {form} finite numbers")
    return values


@dataclass(frozen=True)
class Profile:
    """Sections along a beam.

    Attributes
    ----------
    places : (k,) fractions of the length, rising; constant sections beyond the first and last
    sections : (k,) the sections there
    """

    places: tuple[float, ...]
    sections: tuple[LineSection, ...]

    def line(self, nodes_B: Array, A_BE: Array) -> BeamLine:
        """A beam whose elements have the sections of their middles.

        Parameters
        ----------
        nodes_B : (n, 3) nodes [m]
        A_BE : (n - 1, 3, 3) section axes of the elements in body axes
        """
        count = len(A_BE)
        if len(self.sections) == 1:
            return BeamLine(nodes_B, A_BE, self.sections, np.zeros(count, dtype=np.int64))
        along = lengths_along(nodes_B)
        middles = 0.5 * (along[:-1] + along[1:]) / along[-1]
        sections = tuple(self._at(fraction) for fraction in middles)
        return BeamLine(nodes_B, A_BE, sections, np.arange(count))

    def at_nodes(self, line: BeamLine, given: Sequence[SectionData]) -> tuple[SectionData, ...]:
        """Sections for users: that of a uniform beam, or one for each node.

        `given` are those of the stations, used where a station is at a node.
        """
        if len(given) == 1:
            return (given[0],)
        data = []
        for node, fraction in enumerate(line.along / line.along[-1]):
            nearest = int(np.argmin(np.abs(np.array(self.places) - fraction)))
            section = self._at(float(fraction))
            name = f"{node + 1:04d}"
            if abs(self.places[nearest] - fraction) < 1e-9:
                one = given[nearest]
                name, ply_table, recovery = f"{name} {one.name}", one.ply_table, one.recovery
                data.append(SectionData(name, section.K, section.mass, ply_table, recovery))
            else:
                data.append(SectionData(name, section.K, section.mass))
        return tuple(data)

    def _at(self, fraction: float) -> LineSection:
        weights = [np.interp(fraction, self.places, row) for row in np.eye(len(self.places))]
        used = [(w, s) for w, s in zip(weights, self.sections, strict=True) if w > 0.0]
        return LineSection(
            K=np.sum([w * s.K for w, s in used], axis=0),
            mass=np.sum([w * s.mass for w, s in used], axis=0),
            trapeze=np.sum([w * s.trapeze for w, s in used], axis=0),
        )
