"""Build the modal package of one body from its specification."""

import functools
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..solver.math.arrays import Array
from ..solver.math.independent_changes import independent
from ..solver.package.body.package_schema import ModalPackage, SectionData
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
from .beam.sections import StationSection, analysed_section, given_section, is_given, line_rate
from .design import body_parameters, change_of_inputs, derivatives, of_parameters
from .fenicsx import eigenpairs
from .parameters import Parameter
from .provenance import body_provenance
from .section.section_analysis import analyse

# Stresses of a package are recovered at the points of this rule: four in a quadrilateral.
RECOVERY_DEGREE = 3
SAME = 1e-9  # of the largest change of sections, below which there is none: their error


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

    without: Any = spec.get("design_without", ())

    def at(parameter: Parameter, distance: float) -> tuple[BeamModel, list[SectionData]]:
        """The beam with a parameter moved, and its sections without stresses."""
        own = (t.factor for t in parameter.targets if t.path == "damping_ratio")
        # all else that may move is in the sections
        changed = replace(beam, damping_ratio=beam.damping_ratio + distance * sum(own))
        at_stations = sections.at(parameter, distance)
        moved = beam_model(changed, *(one.line for one in at_stations))
        return moved, sections.data(at_stations)

    asked = [p.linear() if sections.is_analysed(p) else p for p in parameters]
    kept, shares = sections.independent(parameters)
    rates = derivatives(
        [asked[k] for k in kept],
        beam_input(model, eigenpairs)[0],
        modes,
        at,
        lambda p, moved: change_of_inputs(p, [beam_input(one, eigenpairs) for one, _ in moved]),
        lambda moved, modes: beam_package(
            moved[0], modes, moved[1], {}, second_order="second_order" not in without
        ),
        beam.damping_ratio,
    )
    design = of_parameters(parameters, rates, shares)
    if "stresses" not in without:
        for one in design:
            one.values.update(sections.stress_rates(one.name, package.sections, data))
    return replace(package, design=design)


class BeamSections:
    """The sections of a beam: given, or analysed with their derivatives by design parameters."""

    def __init__(
        self, spec: Mapping[str, Any], beam: BeamSpec, parameters: Sequence[Parameter]
    ) -> None:
        without = spec.get("design_without", ())
        strains = {"stresses", "second_order"} - {*without}
        self._left_out = ("recovery/A_BM",) if "ply_axes" in without else ()
        self._places, self._files = [], []
        self._rates = list[dict[str, dict[str, Array]]]()  # of each section, by parameter and path
        self._lines = list[dict[str, LineSection]]()  # those of what the beam is made of
        self._tables = [{k: v for k, v in t.items() if k != "name"} for t in beam.sections]
        self._names = [str(table.get("name", beam.body)) for table in beam.sections]
        self._texts = [toml_text(table) for table in self._tables]
        for row, table in enumerate(self._tables):
            place = ("stations", row, "section") if "stations" in spec else ("section",)
            design = {p.name: p.below(place) for p in parameters if p.below(place)}
            texts = canonical(table), canonical(design)
            file = None if is_given(table) else _analysed(*texts, beam.errors, bool(strains))
            self._places.append(place)
            self._files.append(file)
            self._rates.append({one.name: one.values for one in file.design} if file else {})
            self._lines.append(
                {
                    name: line_rate(file, rates, beam.theory, trapeze="second_order" in strains)
                    for name, rates in self._rates[-1].items()
                    if file is not None
                }
            )
        self._sections = [
            given_section(table) if file is None else analysed_section(file, beam.theory)
            for table, file in zip(self._tables, self._files, strict=True)
        ]

    def at(self, parameter: Parameter | None = None, distance: float = 0.0) -> list[StationSection]:
        """Sections of the stations; with a parameter moved by a distance, without stresses."""
        if parameter is None:
            return self._sections
        return [self._at(row, parameter, distance) for row in range(len(self._tables))]

    def _at(self, row: int, parameter: Parameter, distance: float) -> StationSection:
        place, line = self._places[row], self._sections[row].line
        if self._files[row] is None and parameter.below(place):
            return given_section(parameter.moved(distance, place))
        if parameter.name in self._lines[row]:
            rate = self._lines[row][parameter.name]
            line = LineSection(
                line.K + distance * rate.K,
                line.mass + distance * rate.mass,
                line.trapeze + distance * rate.trapeze,
            )
        return StationSection(line, None, 0, ())

    def independent(self, parameters: Sequence[Parameter]) -> tuple[list[int], Array]:
        """Which parameters (r) change the beam in all ways; shares (r, p) of these in all.

        Those of analysed sections change it in fewer ways than there are plies.
        """

        lines = dict(enumerate(one.line for one in self._sections))
        rates = [
            {row: own[p.name] for row, own in enumerate(self._lines) if p.name in own}
            for p in parameters
        ]
        values, *changes = (
            {(row, n): x for row in of for n, x in lines[row].scaled(of[row]).items()}
            for of in (lines, *rates)
        )
        apart = [k for k, p in enumerate(parameters) if not self.is_analysed(p)]
        return independent(values, changes, SAME, apart)

    def is_analysed(self, parameter: Parameter) -> bool:
        """True if the parameter moves analysed sections only, along their derivatives."""
        own = zip(self._places, self._files, strict=True)
        count = sum(len(parameter.below(place)) for place, file in own if file is not None)
        return count == len(parameter.targets)

    def stress_rates(
        self, name: str, sections: Sequence[SectionData], given: Sequence[SectionData]
    ) -> dict[str, Array]:
        """Derivatives of what only stresses are made of, by path in a package.

        Parameters
        ----------
        name : of the parameter
        sections : of the package
        given : those of the stations, from `data`
        """
        return {
            f"sections/{one.name}/{path}": rate
            for one in sections
            for own, rates in zip(given, self._rates, strict=True)
            if one.recovery is not None and one.recovery is own.recovery
            for path, rate in rates.get(name, {}).items()
            if path.startswith(("plies/", "recovery/")) and path not in self._left_out
        }

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
