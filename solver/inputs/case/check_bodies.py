"""Checks of the bodies of a case beyond types and bounds."""

import numpy as np

from ...errors import InputError, nearest
from ...math.definite import is_positive_definite
from .beams import check_motion
from .body_specs import BodySpec, BodySpecs
from .rich import CHECK, rich_bodies
from .schema import BeamBody, Mechanism, PackageBody, RigidBody, ShellBody

SYMMETRY = 1e-5  # of the largest entry: products of inertia may be given to five digits
TRIANGLE = 1e-5  # relative: the same digits
Body = BeamBody | ShellBody | RigidBody | PackageBody


def check_bodies(mechanism: Mechanism, specs: BodySpecs) -> tuple[dict[str, BodySpec], list[str]]:
    """Return the specifications of the flexible bodies by name, and one line per finding."""
    sound: dict[str, BodySpec] = {}
    found: list[str] = []
    for name, body in mechanism.bodies.items():
        if isinstance(body, BeamBody) and (unknown := _names(f"bodies.{name}", body, mechanism)):
            found += unknown + check_motion(f"bodies.{name}", body)
        elif isinstance(body, BeamBody | ShellBody):
            try:
                if mechanism.fidelity is None:
                    sound[name] = specs.of(name, body, mechanism)
                    continue
                model, check = rich_bodies(name, mechanism)
                sound[name] = specs.of(name, model, mechanism)
                sound[name + CHECK] = specs.of(name, check, mechanism)
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
            else:
                a, b, c = np.linalg.eigvalsh(inertia)
                if c > (a + b) * (1.0 + TRIANGLE):
                    found.append(
                        f"bodies.{name}.inertia = {body.inertia}: no body has principal moments "
                        f"{a:.6g}, {b:.6g}, {c:.6g} kg m2; expected none above the sum of the "
                        "other two"
                    )
    return sound, found


def interfaces(body: Body) -> list[str] | None:
    """Return the interface names of a body; None for a package, whose file has them."""
    return None if isinstance(body, PackageBody) else list(body.interfaces)


def _names(key: str, body: BeamBody, mechanism: Mechanism) -> list[str]:
    found = []
    if body.section not in mechanism.sections:
        hint = nearest(body.section, mechanism.sections)
        found.append(f'{key}.section = "{body.section}": no such section{hint}')
    if body.material is not None and body.material not in mechanism.materials:
        hint = nearest(body.material, mechanism.materials)
        found.append(f'{key}.material = "{body.material}": no such material{hint}')
    return found
