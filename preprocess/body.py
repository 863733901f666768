"""Build the modal package of one body from its specification."""

import functools
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..solver.math.arrays import Array
from ..solver.math.independent import independent
from ..solver.package.body.package_schema import ModalPackage, SectionData
from ..solver.package.common.design import moved
from ..solver.package.common.plain_data import SpecError, canonical, toml_text
from ..solver.package.common.recovery_schema import SectionRecovery
from ..solver.package.section.section_schema import SectionFile
from ..solver.package.section.stress import thinned
from .beam.beam_body import (
    BeamModel,
    beam_input,
    beam_model,
    beam_modes,
    beam_package,
    mode_warnings,
    stiffness_error,
)
from .beam.beam_specification import BeamSpec, read_spec
from .beam.line import LineSection
from .beam.sections import StationSection, analysed_section, given_section, is_given
from .design import body_parameters, change_of_inputs, derivatives, of_parameters
from .fenicsx import eigenpairs
from .parameters import Parameter
from .provenance import body_provenance
from .section.section_analysis import analyse

# Stresses of a package are recovered at the points of this rule: four in a quadrilateral.
RECOVERY_DEGREE = 3
SAME = 1e-12  # of the largest change of sections, below which there is none: rounding


def build_body(spec: Mapping[str, object], **team: Any) -> ModalPackage:
    """Build the package of a beam, a shell or a solid.

    Parameters
    ----------
    spec : plain JSON, see solver/package/specification.py
    team : of a solid: processes that share it

    Raises
    ------
    SpecError : an unknown or missing key, or a value of another type
    ModeError : fewer modes of a kind than requested
    Errors of the analysis (material, mesh) pass through.
    """
    if spec.get("kind") == "shell":
        from .shell.body.shell_body import (
            build_shell_body,  # imported here because beams do not need it
        )

        return build_shell_body(spec)
    if spec.get("kind") == "solid":
        from .solid.solid_body import build_solid_body

        return build_solid_body(spec, **team)
    return _build_beam(spec)


def _build_beam(spec: Mapping[str, object]) -> ModalPackage:
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
    parameters = body_parameters(spec)
    sections = BeamSections(spec, beam, parameters)
    results = sections.at()
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
        {"section": max(result.dofs for result in results), "body": 6 * model.line.n_node},
        {"section": after_section - start, "modes": after_modes - after_section},
        [*(w for result in results for w in result.warnings), *remarks],
    )
    # derivatives belong to all digits of the values beside them
    data = sections.data(results, *(() if parameters else (thinned,)))
    package = beam_package(model, modes, data, provenance)
    if beam.errors:
        stiffer = [result.stiffer() for result in results]
        package = replace(package, stiffness_error=stiffness_error(model, modes, stiffer))
    if not parameters:
        return package

    linear = bool(spec.get("design_linear"))

    def at(parameter: Parameter, distance: float) -> tuple[BeamModel, list[SectionData]]:
        """The beam with a parameter moved, and its sections without rounding."""
        own = (t.factor for t in parameter.targets if t.path == "damping_ratio")
        # all else that may move is in the sections
        changed = replace(beam, damping_ratio=beam.damping_ratio + distance * sum(own))
        at_stations = sections.at(parameter, distance)
        moved = beam_model(changed, *(one.line for one in at_stations))
        return moved, sections.data(at_stations)

    asked = [p.linear() if sections.is_analysed(p) else p for p in parameters]
    kept, shares = list(range(len(asked))), np.eye(len(asked))
    if linear and all(sections.is_analysed(p) for p in parameters):
        kept, shares = sections.independent(parameters)
    rates = derivatives(
        [asked[k] for k in kept],
        beam_input(model, eigenpairs)[0],
        modes,
        at,
        lambda p, moved: change_of_inputs(p, [beam_input(one, eigenpairs) for one, _ in moved]),
        lambda moved, modes: beam_package(moved[0], modes, moved[1], {}, linear=linear),
        beam.damping_ratio,
    )
    return replace(package, design=of_parameters(parameters, rates, shares))


class BeamSections:
    """The sections of a beam: given, or analysed with their derivatives by design parameters."""

    def __init__(
        self, spec: Mapping[str, object], beam: BeamSpec, parameters: Sequence[Parameter]
    ) -> None:
        self._theory, self._linear = beam.theory, bool(spec.get("design_linear"))
        self._places, self._files = [], []
        self._tables = [{k: v for k, v in t.items() if k != "name"} for t in beam.sections]
        self._names = [str(table.get("name", beam.body)) for table in beam.sections]
        self._texts = [toml_text(table) for table in self._tables]
        for row, table in enumerate(self._tables):
            place = ("stations", row, "section") if "stations" in spec else ("section",)
            design = {p.name: p.below(place) for p in parameters if p.below(place)}
            given = is_given(table)
            self._places.append(place)
            texts = canonical(table), canonical(design)
            self._files.append(None if given else _analysed(*texts, beam.errors, not self._linear))

    def at(self, parameter: Parameter | None = None, distance: float = 0.0) -> list[StationSection]:
        """Sections of the stations, with a parameter moved by a distance."""
        return [self._at(row, parameter, distance) for row in range(len(self._tables))]

    def _at(self, row: int, parameter: Parameter | None, distance: float) -> StationSection:
        file, table, place = self._files[row], self._tables[row], self._places[row]
        if parameter is not None and parameter.below(place):
            if file is None:
                table = parameter.moved(distance, place)
            elif self._linear:
                rate = _rates_of(file)[parameter.name]
                K, M = (x + distance * rate.get(n, 0.0) for n, x in (("K", file.K), ("M", file.M)))
                return StationSection(LineSection(K, M, np.zeros(6)), None, 0, ())
            else:
                file = moved(file, {parameter.name: distance})
        return given_section(table) if file is None else analysed_section(file, self._theory)

    def is_analysed(self, parameter: Parameter) -> bool:
        """True if the parameter moves analysed sections only, along their derivatives."""
        own = zip(self._places, self._files, strict=True)
        count = sum(len(parameter.below(place)) for place, file in own if file is not None)
        return count == len(parameter.targets)

    def independent(self, parameters: Sequence[Parameter]) -> tuple[list[int], Array]:
        """Which parameters (r) change the sections in all ways; shares (r, p) of these in all."""
        files = [(row, file) for row, file in enumerate(self._files) if file is not None]
        values = {(row, n): getattr(file, n) for row, file in files for n in ("K", "M")}
        changes = [
            {
                (row, n): rate
                for row, file in files
                for n, rate in _rates_of(file).get(p.name, {}).items()
                if n in ("K", "M")
            }
            for p in parameters
        ]
        return independent(values, changes, SAME)

    def data(
        self,
        results: Sequence[StationSection],
        stored: Callable[[SectionRecovery], SectionRecovery] = lambda recovery: recovery,
    ) -> list[SectionData]:
        """Sections for the package; `stored` rounds the recovery."""
        return [
            SectionData(name, result.line.K, result.line.mass)
            if result.recovery is None
            else SectionData(
                name,
                result.line.K,
                result.line.mass,
                text,
                stored(result.recovery),
                result.end_compliance,
            )
            for name, result, text in zip(self._names, results, self._texts, strict=True)
        ]


def _rates_of(file: SectionFile) -> dict[str, dict[str, Array]]:
    return {one.name: one.values for one in file.design}


@functools.lru_cache(maxsize=256)
def _analysed(text: str, design: str, estimate: bool, strains: bool) -> SectionFile:
    """Analyse a section once and reuse the result for other bodies."""
    asked = json.loads(design)
    return analyse(
        json.loads(text),
        where="section",
        estimate=estimate,
        recovery_degree=RECOVERY_DEGREE,
        **({"design": asked, "design_strains": strains} if asked else {}),
    )
