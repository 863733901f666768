"""Build the modal package of one body from its specification."""

import functools
import json
import time
from typing import Any

from ..solver.package.body.schema import ModalPackage, SectionData
from ..solver.package.common.plain_data import canonical
from ..solver.package.common.table_form import SpecError
from ..solver.package.section.recovery_data import thinned
from ..solver.package.section.schema import SectionFile
from .beam.body import beam_model, beam_modes, beam_package, mode_warnings
from .beam.spec import read_spec
from .fenicsx import eigenpairs
from .provenance import body_provenance
from .section import analyse

# Stresses of a package are recovered at the points of this rule: four in a quadrilateral.
RECOVERY_DEGREE = 3


def build_body(spec: dict[str, Any]) -> ModalPackage:
    """Build the package of a beam or a shell.

    Parameters
    ----------
    spec : plain JSON, see solver/package/body/specification.py

    Raises
    ------
    SpecError : an unknown or missing key, or a value of another type
    ModeError : fewer modes of a kind than requested
    Errors of the analysis (material, mesh) pass through.
    """
    if isinstance(spec, dict) and spec.get("kind") == "shell":
        from .shell.body import build_shell_body  # imported here because beams do not need it

        return build_shell_body(spec)
    return _build_beam(spec)


def _build_beam(spec: dict[str, Any]) -> ModalPackage:
    """Analyse the section, solve the modes and collect the package of one beam.

    The eigenproblem and the inertia invariants use the same mass: the
    `mass_form` of the specification.

    Parameters
    ----------
    spec : plain JSON, see solver/package/body/specification.py

    Raises
    ------
    SpecError : an unknown or missing key, or a value of another type
    ModeError : fewer modes of a kind than requested
    Errors of the section analysis (material, mesh) pass through.
    """
    beam = read_spec(spec)
    start = time.perf_counter()
    section_spec = {key: value for key, value in beam.section.items() if key != "name"}
    name = str(beam.section.get("name", beam.body))
    result = _section(canonical(section_spec))
    after_section = time.perf_counter()
    try:
        model = beam_model(beam, result.K, result.M, result.recovery)
        model.line.section_mass  # noqa: B018  raises for a wrong section mass
    except SpecError:
        raise
    except ValueError as error:
        raise SpecError(f"section: {error}") from error
    modes = beam_modes(model, eigenpairs)
    after_modes = time.perf_counter()
    provenance = body_provenance(
        spec,
        {"section": result.provenance["dofs"], "body": 6 * model.line.n_node},
        {"section": after_section - start, "modes": after_modes - after_section},
        [*result.warnings, *mode_warnings(model, modes)],
    )
    recovery = thinned(result.recovery)
    section = SectionData(name, result.K, result.M, toml_text(section_spec), recovery)
    return beam_package(model, modes, section, provenance)


@functools.lru_cache(maxsize=256)
def _section(text: str) -> SectionFile:
    """Analyse a section once and reuse the result for other bodies."""
    return analyse(
        json.loads(text), where="section", estimate=False, recovery_degree=RECOVERY_DEGREE
    )


def toml_text(table: dict[str, Any], path: str = "") -> str:
    """Plain values, lists and tables as TOML text, for users of a package."""
    lines = [f"{_key(k)} = {_value(v)}" for k, v in table.items() if not isinstance(v, dict)]
    for key, value in table.items():
        if isinstance(value, dict):
            name = f"{path}{_key(key)}"
            lines += [f"\n[{name}]", toml_text(value, f"{name}.").rstrip("\n")]
    return "\n".join(lines).lstrip("\n") + "\n"


def _key(key: str) -> str:
    bare = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if bare else json.dumps(key)


def _value(value: Any) -> str:
    """A value on one line; a table within a list becomes an inline table."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    return json.dumps(value)
