"""Beam bodies: their specification, and what types and bounds do not tell about them."""

from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...package.body.specification import BeamSpecification
from ..common.table import plain_table
from .modes import check_modes
from .schema import BeamBody, Mechanism
from .sections import check_section, section_spec

ENDS = {"start": 0.0, "end": 1.0}


def beam_spec(
    name: str, body: BeamBody, mechanism: Mechanism, folder: Path
) -> tuple[BeamSpecification, list[Path]]:
    """Return the specification of a beam and the files beside the case file that it is made from.

    Parameters
    ----------
    body : its section and material exist
    folder : of the case file, where relative paths start

    Raises
    ------
    InputError
        What is wrong with the body, one line each.
    """
    key = f"bodies.{name}"
    found = check_section(key, body, mechanism)
    section, sources = dict[str, Any](), list[Path]()
    if body.material is not None or not found:
        try:
            section, sources = section_spec(body, mechanism, folder)
        except InputError as error:
            found += str(error).splitlines()
    found += check_motion(key, body)
    if found:
        raise InputError("\n".join(found))
    spec: BeamSpecification = {
        "body": name,
        "kind": "beam",
        "length": body.length,
        "elements": body.elements,
        "x2_axis": body.x2_axis,
        "section": section,
        "theory": body.theory,
        "mass_form": body.mass_form,
        "reference": plain_table(body.reference),
        "modes": [plain_table(mode) for mode in body.modes],
        "damping_ratio": body.damping_ratio,
        "interfaces": {k: plain_table(v) for k, v in body.interfaces.items()},
    }
    return spec, sources


def check_motion(key: str, body: BeamBody) -> list[str]:
    """Return what is wrong with a beam's modes, axes and elements; `key` names it."""
    fractions = {
        name: i.at if isinstance(i.at, float) else ENDS[i.at] for name, i in body.interfaces.items()
    }
    found = check_modes(key, body.reference, body.modes, fractions)
    x2 = np.array(body.x2_axis)
    if abs(np.linalg.norm(x2) - 1.0) > 1e-9 or abs(x2[0]) > 1e-9:
        found.append(f"{key}.x2_axis = {body.x2_axis}: expected a unit vector normal to body x")
    least = len({0.0, 1.0, *fractions.values()}) - 1
    if body.elements < least:
        found.append(
            f"{key}.elements = {body.elements}: expected at least {least}: "
            "every interface needs a node"
        )
    return found
