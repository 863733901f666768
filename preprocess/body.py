"""Build the modal package of one body from its specification."""

import functools
import json
import time
from typing import Any

from ..solver.package.body.schema import ModalPackage, SectionData
from ..solver.package.common.plain_data import SpecError, canonical, toml_text
from ..solver.package.section.schema import SectionFile
from ..solver.package.section.stress import thinned
from .beam.body import beam_model, beam_modes, beam_package, mode_warnings
from .beam.sections import StationSection, analysed_section, given_section, is_given
from .beam.spec import read_spec
from .fenicsx import eigenpairs
from .provenance import body_provenance
from .section.analysis import analyse

# Stresses of a package are recovered at the points of this rule: four in a quadrilateral.
RECOVERY_DEGREE = 3


def build_body(spec: dict[str, Any]) -> ModalPackage:
    """Build the package of a beam, a shell or a solid.

    Parameters
    ----------
    spec : plain JSON, see solver/package/specification.py

    Raises
    ------
    SpecError : an unknown or missing key, or a value of another type
    ModeError : fewer modes of a kind than requested
    Errors of the analysis (material, mesh) pass through.
    """
    if isinstance(spec, dict) and spec.get("kind") == "shell":
        from .shell.body.body import build_shell_body  # imported here because beams do not need it

        return build_shell_body(spec)
    if isinstance(spec, dict) and spec.get("kind") == "solid":
        from .solid.body import build_solid_body

        return build_solid_body(spec)
    return _build_beam(spec)


def _build_beam(spec: dict[str, Any]) -> ModalPackage:
    """Analyse the section, solve the modes and collect the package of one beam.

    The eigenproblem and the inertia invariants use the same mass: the
    `mass_form` of the specification.

    Parameters
    ----------
    spec : plain JSON, see solver/package/specification.py

    Raises
    ------
    SpecError : an unknown or missing key, or a value of another type
    ModeError : fewer modes of a kind than requested
    Errors of the section analysis (material, mesh) pass through.
    """
    beam = read_spec(spec)
    start = time.perf_counter()
    described = [{k: v for k, v in table.items() if k != "name"} for table in beam.sections]
    names = [str(table.get("name", beam.body)) for table in beam.sections]
    results = [_section(table, beam.theory) for table in described]
    after_section = time.perf_counter()
    try:
        model = beam_model(beam, *(result.line for result in results))
        for section in model.line.sections:
            section.slice_mass  # noqa: B018  raises for a wrong section mass
    except SpecError:
        raise
    except ValueError as error:
        raise SpecError(f"section: {error}") from error
    modes = beam_modes(model, eigenpairs)
    after_modes = time.perf_counter()
    remarks = [] if spec.get("candidates") else mode_warnings(model, modes)
    provenance = body_provenance(
        spec,
        {
            "section": max(result.dofs for result in results),
            "body": 6 * model.line.n_node,
        },
        {"section": after_section - start, "modes": after_modes - after_section},
        [*(w for result in results for w in result.warnings), *remarks],
    )
    sections = [
        SectionData(name, result.line.K, result.line.mass)
        if result.recovery is None
        else SectionData(
            name,
            result.line.K,
            result.line.mass,
            toml_text(table),
            thinned(result.recovery),
            result.end_compliance,
        )
        for name, result, table in zip(names, results, described, strict=True)
    ]
    return beam_package(model, modes, sections, provenance)


def _section(table: dict[str, Any], theory: str) -> StationSection:
    if is_given(table):
        return given_section(table)
    return analysed_section(_analysed(canonical(table)), theory)


@functools.lru_cache(maxsize=256)
def _analysed(text: str) -> SectionFile:
    """Analyse a section once and reuse the result for other bodies."""
    return analyse(
        json.loads(text), where="section", estimate=False, recovery_degree=RECOVERY_DEGREE
    )
