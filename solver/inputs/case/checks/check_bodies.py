"""Checks of the bodies of a case, and of places on them, beyond types and bounds."""

import numpy as np

from ....errors import InputError, nearest, unknown
from ....math.definite import is_positive_definite
from ..bodies.beams import check_motion
from ..bodies.body_specs import BodySpec, BodySpecs
from ..bodies.rich import CHECK, rich_bodies
from ..tables.beam_schema import BeamBody
from ..tables.body_schema import ImportedBody, PackageBody, RigidBody, ShellBody, SolidBody
from ..tables.schema import Mechanism

SYMMETRY = 1e-5  # of the largest entry: products of inertia may be given to five digits
TRIANGLE = 1e-5  # relative: the same digits
Body = BeamBody | ShellBody | SolidBody | RigidBody | PackageBody | ImportedBody


def check_bodies(mechanism: Mechanism, specs: BodySpecs) -> tuple[dict[str, BodySpec], list[str]]:
    """Return the specifications of the flexible bodies by name, and one line per finding."""
    sound: dict[str, BodySpec] = {}
    found: list[str] = []
    for name, body in mechanism.bodies.items():
        if isinstance(body, BeamBody) and (unknown := _names(f"bodies.{name}", body, mechanism)):
            found += unknown + check_motion(f"bodies.{name}", body)
        elif isinstance(body, BeamBody | ShellBody | SolidBody | ImportedBody):
            whole = getattr(body, "part_of", None) or name  # equal segments share a package
            try:
                if mechanism.fidelity is None or isinstance(body, SolidBody | ImportedBody):
                    sound[name] = specs.of(whole, body, mechanism)
                    continue
                model, check = rich_bodies(name, mechanism)
                sound[name] = specs.of(whole, model, mechanism, candidates=True)
                sound[name + CHECK] = specs.of(whole, check, mechanism, candidates=True)
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
    """Return the interface names of a body; None if another file has them."""
    return None if isinstance(body, PackageBody | ImportedBody) else list(body.interfaces)


def _names(key: str, body: BeamBody, mechanism: Mechanism) -> list[str]:
    found = []
    places = [(key, body.section, body.material)]
    places += [(f"{key}.stations[{i}]", s.section, s.material) for i, s in enumerate(body.stations)]
    if body.section is None and all(s.at > 0.0 or s.section is not None for s in body.stations):
        found.append(f"{key}.section: missing; expected the name of a section, or a `table`")
    for where, section, material in places:
        if section is not None:
            found += unknown(f"{where}.section", section, "section", mechanism.sections)
        if material is not None:
            found += unknown(f"{where}.material", material, "material", mechanism.materials)
    return found


def check_place(key: str, place: str, mechanism: Mechanism, *, ground: bool) -> list[str]:
    """Return errors of a place "BODY.INTERFACE" or "ground.POINT"."""
    owner, dot, point = place.partition(".")
    if not dot:
        expected = '"BODY.INTERFACE"' + (' or "ground.POINT"' if ground else "")
        return [f'{key} = "{place}": expected {expected}']
    if owner == "ground" and ground:
        if point in mechanism.ground:
            return []
        hint = nearest(point, mechanism.ground)
        return [f'{key} = "{place}": the ground has no point "{point}"{hint}']
    if owner not in mechanism.bodies:
        return [f'{key} = "{place}": there is no body "{owner}"{nearest(owner, mechanism.bodies)}']
    known = interfaces(mechanism.bodies[owner])
    if known is not None and point not in known:
        return [
            f'{key} = "{place}": body "{owner}" has no interface "{point}"{nearest(point, known)}'
        ]
    return []
