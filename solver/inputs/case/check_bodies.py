"""Checks of the bodies of a case beyond types and bounds."""

import numpy as np

from ...errors import InputError, nearest
from ...math.definite import is_positive_definite
from .beams import check_motion
from .body_specs import BodySpec, BodySpecs
from .schema import BeamBody, Mechanism, PackageBody, RigidBody, ShellBody

SYMMETRY = 1e-5  # of the largest entry: products of inertia may be given to five digits
Body = BeamBody | ShellBody | RigidBody | PackageBody


def check_bodies(mechanism: Mechanism, specs: BodySpecs) -> tuple[dict[str, BodySpec], list[str]]:
    """Return the specifications of the flexible bodies by name, and one line per finding."""
    sound: dict[str, BodySpec] = {}
    found: list[str] = []
    for name, body in mechanism.bodies.items():
        if isinstance(body, BeamBody) and (unknown := _names(f"bodies.{name}", body, mechanism)):
            found += unknown + check_motion(f"bodies.{name}", body)
        elif isinstance(body, BeamBody | ShellBody):
            whole = getattr(body, "part_of", None) or name  # equal segments share a package
            try:
                sound[name] = specs.of(whole, body, mechanism)
            except InputError as error:
                found += str(error).splitlines()
        elif isinstance(body, RigidBody):
            inertia = np.array(body.inertia)
            gap = np.abs(inertia - inertia.T).max()
            if gap > SYMMETRY * np.abs(inertia).max() or not is_positive_definite(inertia):
                found.append(
                    f"bodies.{name}.inertia = {body.inertia}: expected a symmetric, "
                    "positive definite 3x3 matrix"
                )
    return sound, found


def interfaces(body: Body) -> list[str] | None:
    """Return the interface names of a body; None for a package, whose file has them."""
    return None if isinstance(body, PackageBody) else list(body.interfaces)


def _names(key: str, body: BeamBody, mechanism: Mechanism) -> list[str]:
    found = []
    places = [(key, body.section, body.material)]
    places += [(f"{key}.stations[{i}]", s.section, s.material) for i, s in enumerate(body.stations)]
    for where, section, material in places:
        if section not in mechanism.sections:
            hint = nearest(section, mechanism.sections)
            found.append(f'{where}.section = "{section}": no such section{hint}')
        if material is not None and material not in mechanism.materials:
            hint = nearest(material, mechanism.materials)
            found.append(f'{where}.material = "{material}": no such material{hint}')
    return found
