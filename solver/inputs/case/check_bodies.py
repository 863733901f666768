"""Checks of the bodies of a case beyond types and bounds."""

from pathlib import Path

import numpy as np

from ...errors import nearest
from .modes import check_modes
from .schema import BeamBody, Mechanism, PackageBody, RigidBody, ShellBody
from .sections import check_section
from .shells import check_shell

Body = BeamBody | ShellBody | RigidBody | PackageBody


def check_bodies(mechanism: Mechanism, folder: Path) -> list[str]:
    """Return one line per finding; `folder` is that of the case file."""
    found = []
    for name, body in mechanism.bodies.items():
        if isinstance(body, BeamBody):
            found += _check_beam(f"bodies.{name}", body, mechanism, folder)
        elif isinstance(body, ShellBody):
            found += check_shell(f"bodies.{name}", body, folder)
        elif isinstance(body, RigidBody):
            inertia = np.array(body.inertia)
            if not np.allclose(inertia, inertia.T) or np.linalg.eigvalsh(inertia)[0] <= 0:
                found.append(
                    f"bodies.{name}.inertia = {body.inertia}: expected a symmetric, "
                    "positive definite 3x3 matrix"
                )
    return found


def interfaces(body: Body) -> list[str] | None:
    """Return the interface names of a body; None for a package, whose file has them."""
    return None if isinstance(body, PackageBody) else list(body.interfaces)


def _check_beam(key: str, body: BeamBody, mechanism: Mechanism, folder: Path) -> list[str]:
    found = []
    if body.section not in mechanism.sections:
        hint = nearest(body.section, mechanism.sections)
        found.append(f'{key}.section = "{body.section}": no such section{hint}')
    if body.material is not None and body.material not in mechanism.materials:
        hint = nearest(body.material, mechanism.materials)
        found.append(f'{key}.material = "{body.material}": no such material{hint}')
    if not found:
        found += check_section(key, body, mechanism, folder)
    ends = {"start": 0.0, "end": 1.0}
    fractions = {
        name: i.at if isinstance(i.at, float) else ends[i.at] for name, i in body.interfaces.items()
    }
    found += check_modes(key, body.reference, body.modes, fractions)
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
