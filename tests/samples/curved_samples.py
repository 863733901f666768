"""Beams of a case whose line is curved or twisted, as entries of a specification."""

from typing import Any

from plymotion.solver.inputs.case.bodies.beams import division, line_of, line_table
from plymotion.solver.inputs.case.tables.beam_keys import BeamBody

BAR = {"section": "s", "material": "m", "interfaces": {"root": {"at": "start"}}, "kind": "beam"}


def meshed(elements: int, **keys: Any) -> dict[str, Any]:
    """Entries of a specification for the line of a beam of the case."""
    body = BeamBody.model_validate({**BAR, "elements": elements, **keys})
    line = line_of(body)
    nodes = division(body)
    return {"length": line.length, "elements": len(nodes) - 1, "line": line_table(line, nodes)}
