"""Checks of a case beyond types and bounds: existing names, expressions, consistent values."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ...dynamics.elements.forces.table import ELEMENTS
from ...dynamics.elements.joints.table import JOINTS
from ...dynamics.tolerances import LAST_INSTANT
from ...errors import InputError, collected, few, nearest, unknown
from ...integrators.table import treatment_of
from ...math import laws
from ...math.arrays import is_positive_definite
from ...math.expressions import operations as op
from ...math.expressions.parse import MADE, NAMES
from ...math.laws import NamedCurve
from ...math.rows import column
from ..common.materials import check_materials
from .bodies.beams import check_motion, is_plain
from .bodies.segments import check_names, in_segments
from .bodies.specifications import CHECK, BodySpec, BodySpecs, check_fidelity, rich_bodies
from .expressions import (
    WORDS,
    CaseScope,
    PlaceCheck,
    check_couplings,
    drives,
    expression,
    force_terms,
    is_along,
    joint_starts,
    law,
    of_time_alone,
    state_rates,
)
from .messages import RIGID
from .record import KINDS, elsewhere, parts
from .tables.beam_keys import BeamBody
from .tables.bodies import ImportedBody, PackageBody, RigidBody, ShellBody, SolidBody
from .tables.kinds import ForceTable, LoadTable
from .tables.laws import DriveTable, RotationDrive, TranslationDrive
from .tables.rotor import Wind
from .tables.schema import Mechanism, output_findings
from .tables.signals import (
    DifferenceSignal,
    ForceSignal,
    JointSignal,
    NormSignal,
    PointSignal,
    ReactionSignal,
    RotorSignal,
    SectionSignal,
    Signal,
    StrengthSignal,
)

Body = BeamBody | ShellBody | SolidBody | RigidBody | PackageBody | ImportedBody


def interfaces(body: Body) -> list[str] | None:
    """Return the interface names of a body; None if another file has them."""
    return None if isinstance(body, PackageBody | ImportedBody) else list(body.interfaces)


def check_place(key: str, place: str, mechanism: Mechanism, *, ground: bool) -> list[str]:
    """Return errors of a place "BODY.INTERFACE" or "ground.POINT".

    Parameters
    ----------
    key : key of the input file, for messages
    place : text of the place
    mechanism : tables of the case, checked for types and bounds
    ground : whether a point of the ground is allowed
    """
    owner, dot, point = place.partition(".")
    if not dot:
        expected = '"BODY.INTERFACE"' + (' or "ground.POINT"' if ground else "")
        body = mechanism.bodies.get(owner)
        known = list(mechanism.ground) if owner == "ground" else body and interfaces(body)
        such = f", such as {few(f'{owner}.{name}' for name in known)}" if known else ""
        return [f'{key} = "{place}": expected {expected}{such}']
    if owner == "ground" and ground:
        if point in mechanism.ground:
            return []
        hint = nearest(point, mechanism.ground)
        return [f'{key} = "{place}": the ground has no point "{point}"{hint}']
    if owner not in mechanism.bodies:
        bodies = [*mechanism.bodies, *["ground"] * ground]
        return [f'{key} = "{place}": there is no body "{owner}"{nearest(owner, bodies)}']
    known = interfaces(mechanism.bodies[owner])
    if known is not None and point not in known:
        return [
            f'{key} = "{place}": body "{owner}" has no interface "{point}"{nearest(point, known)}'
        ]
    return []


def check_combined(mechanism: Mechanism) -> Iterator[str]:
    """Yield what is wrong with the combined signals of a run, apart from the other run."""
    signals: Mapping[str, Any] = mechanism.signals
    for name, signal in signals.items():
        if signal.kind not in KINDS:
            continue
        for part in parts(signal):
            yield from unknown(f"signals.{name}.of", part, "signal", signals)
        if _depends_on(name, name, signals, frozenset()):
            yield f"signals.{name}: depends on itself; expected other signals"
        if mechanism.fidelity is not None and signal.run is not None:
            yield f"signals.{name}.run: expected none with [fidelity]"


def _depends_on(name: str, wanted: str, signals: Mapping[str, Any], seen: frozenset[str]) -> bool:
    if name in seen or name not in signals:
        return False
    inner = parts(signals[name])
    return wanted in inner or any(
        _depends_on(part, wanted, signals, seen | {name}) for part in inner
    )


def check_elsewhere(mechanism: Mechanism, runs: Mapping[str, Mechanism]) -> Iterator[str]:
    """Yield what is wrong with the runs that the combined signals of a run read."""
    signals: Mapping[str, Any] = mechanism.signals
    for name, signal in signals.items():
        if not elsewhere(signal):
            continue
        if signal.run not in runs:
            yield from unknown(f"signals.{name}.run", signal.run, "run", runs)
            continue
        there: Mapping[str, Any] = runs[signal.run].signals
        for part in elsewhere(signal):
            if part not in there:
                yield f'signals.{name}: run {signal.run} has no signal "{part}"'
            elif elsewhere(there[part]):
                yield f'signals.{name}: "{part}" reads another run itself; expected a plain signal'


RESTS = 0.01  # of the largest speed of a table of a drive: it has come to rest


def check_force(key: str, force: ForceTable, mechanism: Mechanism) -> list[str]:
    """Return errors of the expressions of a force.

    Parameters
    ----------
    key : key of the input file, for messages
    force : table of the force
    mechanism : tables of the case, checked for types and bounds
    """
    errors: list[str] = []
    with collected(errors):
        if is_along(force):
            force_terms(key.partition(".")[2], force, mechanism, _places(mechanism))
        elif (of_time := law(force)) is not None and of_time.expression is not None:
            scope = CaseScope(mechanism, check=_places(mechanism))
            expression(of_time.expression, scope, f"{key}.expression")
    return errors


def check_tables(mechanism: Mechanism) -> list[str]:
    """Return tables whose names mean something else in expressions."""
    others = {
        "a function of expressions": {*op.FUNCTIONS, *MADE, *WORDS},
        "a name of expressions": {*NAMES, "x", "v"},
        "one of [parameters] too": mechanism.parameters,
    }
    return [
        f"tables.{name}: is {what}; expected another name"
        for name in mechanism.tables
        for what, names in others.items()
        if name in names
    ]


def _places(mechanism: Mechanism) -> PlaceCheck:
    return lambda place: check_place("reads", place, mechanism, ground=True)


def _stop(key: str, table: DriveTable, t_end: float) -> list[str]:
    """Return the error of a table that ends within the run before its curve has come to rest."""
    times, values = column(table.times or []), column(table.values or [])
    if times[-1] >= t_end * (1.0 - LAST_INSTANT):
        return []
    curve = laws.table(times, values, table.interpolation)
    s, c = times[-1] - times[-2], curve.coefficients
    speed = float(sum(i * c[-2, i] * s ** (i - 1) for i in range(1, c.shape[1])))
    if abs(speed) <= RESTS * max(float(np.abs(c[:, 1]).max()), abs(speed)):
        return []
    return [
        f"{key}.table: ends at t = {times[-1]:g} s with a speed of {speed:.3g}, and the drive "
        f"would stop there at once, because the last value is kept; expected times up to "
        f"solver.t_end = {t_end:g} s, or values that come to rest"
    ]


def check_drive(
    key: str, drive: RotationDrive | TranslationDrive, mechanism: Mechanism
) -> list[str]:
    """Return errors of the law of a drive: an expression reads the time alone, no speed jumps.

    Parameters
    ----------
    key : key of the input file, for messages
    drive : table of the drive
    mechanism : tables of the case, checked for types and bounds
    """
    if drive.table is not None:
        return _stop(key, drive.table, mechanism.solver.t_end)
    if drive.expression is None:
        return []
    try:
        tree = expression(drive.expression, CaseScope(mechanism), f"{key}.expression")
    except InputError as error:
        return [str(error)]
    if not of_time_alone(tree):
        return [
            f'{key}.expression = "{drive.expression}": expected the time t and parameters alone; '
            "a drive that follows the motion is a controller or coordinate_force"
        ]
    for leaf in tree.leaves():
        curve = leaf.quantity
        if isinstance(curve, NamedCurve) and mechanism.tables[curve.name].interpolation == "linear":
            return [
                f"{key}.expression: calls tables.{curve.name}, whose rate jumps; expected "
                'interpolation = "cubic" or "pchip" in a drive'
            ]
    return []


SYMMETRY = 1e-5  # of the largest entry: products of inertia may be given to five digits
TRIANGLE = 1e-5  # relative: the same digits


def check_bodies(mechanism: Mechanism, specs: BodySpecs) -> tuple[dict[str, BodySpec], list[str]]:
    """Return the specifications of the flexible bodies by name, and one line per finding."""
    sound: dict[str, BodySpec] = {}
    errors: list[str] = []
    for name, body in mechanism.bodies.items():
        if isinstance(body, BeamBody) and (wrong := _names(f"bodies.{name}", body, mechanism)):
            errors += wrong + check_motion(f"bodies.{name}", body)
        elif isinstance(body, BeamBody | ShellBody | SolidBody | ImportedBody):
            whole = getattr(body, "part_of", None) or name  # equal segments share a package
            with collected(errors):
                if mechanism.fidelity is None or isinstance(body, SolidBody | ImportedBody):
                    sound[name] = specs.of(whole, body, mechanism)
                    continue
                model, check = rich_bodies(name, mechanism)
                sound[name] = specs.of(whole, model, mechanism, candidates=True)
                sound[name + CHECK] = specs.of(whole, check, mechanism, candidates=True)
        elif isinstance(body, RigidBody):
            inertia = np.array(body.inertia)
            gap, free = np.abs(inertia - inertia.T).max(), "inertia" in mechanism.allow
            regular = is_positive_definite(inertia)
            if body.mass == 0.0 or free:  # joints must hold it: require_inertia
                regular = regular or float(np.linalg.eigvalsh(inertia)[0]) >= 0.0
            if gap > SYMMETRY * np.abs(inertia).max() or not regular:
                errors.append(
                    f"bodies.{name}.inertia = {body.inertia}: expected a symmetric, "
                    "positive definite 3x3 matrix"
                )
            elif not free:
                a, b, c = np.linalg.eigvalsh(inertia)
                if c > (a + b) * (1.0 + TRIANGLE):
                    errors.append(
                        f"bodies.{name}.inertia = {body.inertia}: no body has principal moments "
                        f"{a:.6g}, {b:.6g}, {c:.6g} kg m2; expected none above the sum of the "
                        "other two"
                    )
    return sound, errors


def _names(key: str, body: BeamBody, mechanism: Mechanism) -> list[str]:
    errors = []
    places = [(key, body.section, body.material)]
    places += [(f"{key}.stations.{i}", s.section, s.material) for i, s in enumerate(body.stations)]
    if body.section is None and all(s.at > 0.0 or s.section is not None for s in body.stations):
        errors.append(f"{key}.section: missing; expected the name of a section, or a `table`")
    for where, section, material in places:
        if section is not None:
            errors += unknown(f"{where}.section", section, "section", mechanism.sections)
        if material is not None:
            errors += unknown(f"{where}.material", material, "material", mechanism.materials)
    return errors


def cross_check(mechanism: Mechanism, specs: BodySpecs) -> tuple[dict[str, BodySpec], list[str]]:
    """Return the specifications of the flexible bodies by name, and one line per finding."""
    bodies, wrong = check_bodies(mechanism, specs)
    errors = check_materials(mechanism.materials) + wrong
    errors += check_names(mechanism) + _joints(mechanism) + _two_drives(mechanism)
    errors += check_tables(mechanism)
    with collected(errors):
        state_rates(mechanism, _places(mechanism))
    errors += _forces(mechanism) + check_couplings(mechanism)
    for name, mass in mechanism.masses.items():
        errors += check_place(f"masses.{name}.at", mass.at, mechanism, ground=False)
    errors += _rotor(mechanism)
    for name, signal in mechanism.signals.items():
        key = f"signals.{name}"
        wrong = _signal(key, signal, mechanism)
        if isinstance(signal, StrengthSignal) and not wrong:
            wrong = without_strengths(f'{key}.body = "{signal.body}"', bodies.get(signal.body))
        errors += wrong
    errors += check_combined(mechanism)
    spin = mechanism.solver.spin
    if spin is not None and spin.speed != 0.0 and mechanism.solver.start != "equilibrium":
        errors.append(
            f'solver.spin.speed = {spin.speed:g}: expected 0, or solver.start = "equilibrium"; '
            "bodies take velocity and angular_velocity"
        )
    errors += check_fidelity(mechanism)
    errors += output_findings(mechanism)
    with collected(errors):
        treatment_of(mechanism.solver)
    return bodies, errors


def _owners(between: list[str]) -> list[str]:
    return [place.partition(".")[0] for place in between]


def _between(key: str, between: list[str], mechanism: Mechanism, *, one_body: bool) -> list[str]:
    """Return errors of a pair of places; `one_body`: both may be of the same body."""
    errors = []
    for place in between:
        errors += check_place(key, place, mechanism, ground=True)
    one, two = _owners(between)
    if between[0] == between[1]:
        errors.append(f"{key} = {between}: expected two different places")
    elif one == two and (one == "ground" or not one_body):
        what = "the ground" if one == "ground" else f"body {one}"
        errors.append(f"{key} = {between}: both are of {what}; expected places of two bodies")
    return errors


def _right_angle(key: str, one: list[float], two: list[float]) -> list[str]:
    a, b = np.array(one), np.array(two)
    if abs(a @ b) <= 1e-6 * np.linalg.norm(a) * np.linalg.norm(b):
        return []
    return [f"{key} = {two}: expected a vector at a right angle to axis = {one}"]


def _joints(mechanism: Mechanism) -> list[str]:
    errors = []
    for name, joint in mechanism.joints.items():
        key = f"joints.{name}"
        errors += _between(f"{key}.between", joint.between, mechanism, one_body=False)
        axis, axis_2 = getattr(joint, "axis", None), getattr(joint, "axis_2", None)
        if axis is not None and axis_2 is not None:
            errors += _right_angle(f"{key}.axis_2", axis, axis_2)
        for drive_key, drive in drives(joint).items():
            errors += check_drive(f"{key}.{drive_key}", drive, mechanism)
            if drive_key in joint_starts(joint):
                errors.append(f"{key}.{drive_key}: expected no drive of a coordinate with a start")
    return errors


def _two_drives(mechanism: Mechanism) -> list[str]:
    """Return pairs of drives between the same two bodies about or along parallel axes."""
    errors: list[str] = []
    seen: list[tuple[str, set[str], bool, np.ndarray]] = []
    for name, joint in mechanism.joints.items():
        for drive_key, drive in drives(joint).items():
            axis = np.array(getattr(joint, "axis", None))
            axis = axis / np.linalg.norm(axis)
            bodies, kind = set(_owners(joint.between)), isinstance(drive, RotationDrive)
            key = f"joints.{name}.{drive_key}"
            for other_key, other_bodies, other_kind, other_axis in seen:
                parallel = np.linalg.norm(np.cross(axis, other_axis)) < 1e-6
                if bodies == other_bodies and kind == other_kind and parallel:
                    errors.append(f"{key}: expected one drive on a coordinate; {other_key} has it")
            seen.append((key, bodies, kind, axis))
    return errors


def _forces(mechanism: Mechanism) -> list[str]:
    errors = []
    for name, force in mechanism.forces.items():
        key = f"forces.{name}"
        errors += check_force(key, force, mechanism)
        if isinstance(force, LoadTable):
            errors += check_place(f"{key}.at", force.at, mechanism, ground=False)
            continue
        if is_along(force):
            if force.between is not None:
                errors += _between(f"{key}.between", force.between, mechanism, one_body=True)
            continue
        errors += _between(f"{key}.between", force.between, mechanism, one_body=True)
        axis, axis_1 = getattr(force, "axis", None), getattr(force, "axis_1", None)
        if axis is not None and axis_1 is not None:
            errors += _right_angle(f"{key}.axis_1", axis, axis_1)
        acts_by = ELEMENTS[force.kind].acts_by
        if acts_by and not any(getattr(force, word) for word in acts_by):
            *most, last = acts_by
            words = f"{', '.join(most)} or {last}" if most else last
            errors.append(f"{key}: has no effect; expected {words}")
    return errors


WHOLE = 1e-6  # [deg] by which a polar may end before half a turn


def _rotor(mechanism: Mechanism) -> list[str]:
    rotor = mechanism.rotor
    if rotor is None:
        return []
    errors = check_place("rotor.hub", rotor.hub, mechanism, ground=False)
    for blade in [name for name in rotor.blades if name not in rotor.divided]:
        missing = unknown("rotor.blades", blade, "body", mechanism.bodies)
        known = None if missing else interfaces(mechanism.bodies[blade])
        errors += missing
        for section in rotor.sections if known is not None else ():
            errors += unknown(f"rotor.blades: {blade}", section.place, "interface", known or [])
    for k, section in enumerate(rotor.sections):
        where = f'table = "{rotor.table}" row {k + 1}: ' if rotor.table else f"sections.{k}."
        errors += unknown(f"rotor.{where}polar", section.polar, "polar", rotor.polars)
    for name, polar in rotor.polars.items():
        first, last = polar.alpha_deg[0], polar.alpha_deg[-1]
        if max(first, -last) > WHOLE - 180.0:
            errors.append(
                f"rotor.polars.{name}.alpha_deg: from {first:g} to {last:g}; expected -180 to 180, "
                "because a blade may stand still"
            )
    return errors + _wind(rotor.wind, mechanism)


def _wind(wind: Wind, mechanism: Mechanism) -> list[str]:
    times, end, key = wind.times, mechanism.solver.t_end, f'rotor.wind.file = "{wind.file}"'
    if wind.speed is not None:
        key = "rotor.wind.speed"
        if wind.speed.expression is not None:
            key = f"{key}.expression"
            try:
                tree = expression(wind.speed.expression, CaseScope(mechanism), key)
            except InputError as error:
                return [str(error)]
            message = f'{key} = "{wind.speed.expression}": expected the time t and parameters alone'
            return [] if of_time_alone(tree) else [message]
        if wind.speed.table is not None:
            key, times = f"{key}.table", column(wind.speed.table.times or []).tolist()
    if times is None or times[-1] >= end:
        return []
    return [f"{key}: ends at {times[-1]:g} s; expected up to solver.t_end = {end:g} s"]


def _signal(
    key: str,
    signal: Signal,
    mechanism: Mechanism,
) -> list[str]:
    if isinstance(signal, PointSignal):
        errors = check_place(f"{key}.at", signal.at, mechanism, ground=False)
        if signal.seen_from is not None:
            errors += check_place(f"{key}.seen_from", signal.seen_from, mechanism, ground=False)
        return errors
    if isinstance(signal, JointSignal | ReactionSignal):
        errors = unknown(f"{key}.joint", signal.joint, "joint", mechanism.joints)
        if not errors and isinstance(signal, JointSignal):
            kind = mechanism.joints[signal.joint].kind
            free = [coordinate.name for coordinate in JOINTS[kind].coordinates]
            if signal.coordinate not in free:
                given = f' = "{signal.coordinate}":' if signal.coordinate else ": missing;"
                return [
                    f"{key}.coordinate{given} joint {signal.joint} is {kind}; expected "
                    f"{' or '.join(free) or 'another joint'}"
                ]
        return errors
    if isinstance(signal, DifferenceSignal | NormSignal):
        return []
    if isinstance(signal, RotorSignal):
        words = f'{key}.kind = "rotor": expected a table [rotor]'
        return [words] if mechanism.rotor is None else []
    if isinstance(signal, ForceSignal):
        able = [name for name, force in mechanism.forces.items() if is_along(force)]
        able += list(mechanism.couplings)
        if signal.of in mechanism.forces and signal.of not in able:
            kind = mechanism.forces[signal.of].kind
            return [
                f'{key}.of = "{signal.of}": a {kind} does not act along a coordinate; expected a '
                "force that does, or a coupling"
            ]
        return unknown(f"{key}.of", signal.of, "force or coupling", able)
    if wrong := unknown(f"{key}.body", signal.body, "body", mechanism.bodies):
        return wrong
    body = mechanism.bodies[signal.body]
    if isinstance(body, RigidBody):
        return [f'{key}.body = "{signal.body}": {RIGID}']
    if isinstance(signal, StrengthSignal):
        errors = _of_strength(key, signal, body)
        if errors:
            return errors
    elif isinstance(body, ShellBody | SolidBody):
        return [
            f'{key}.body = "{signal.body}": expected a beam, this one is a {body.kind}: its '
            f"{'plies have' if body.kind == 'shell' else 'surface has'} signals of kind "
            '"strength_ratio"'
        ]
    straight = isinstance(body, BeamBody) and is_plain(body)
    if isinstance(signal, SectionSignal) and signal.method == "equilibrium" and not straight:
        return [
            f'{key}.method = "equilibrium": expected modes; {signal.body} is no straight beam '
            "without twist"
        ]
    length = body.length if isinstance(body, BeamBody) else None
    if length and signal.x is not None and not 0.0 <= signal.x <= length:
        return [f"{key}.x = {signal.x:g}: expected 0 to {length:g} m, the length of the body"]
    return []


def _of_strength(key: str, signal: StrengthSignal, body: Body) -> list[str]:
    """Return errors of the places of a signal of strength."""
    errors = []
    surface = isinstance(body, ShellBody | SolidBody)
    if surface and signal.x is not None:
        what = f"{signal.body} is a {body.kind}"
        errors.append(f"{key}.x = {signal.x:g}: expected for beams only, {what}")
    expected = 3 if surface else 2
    known = surface or isinstance(body, BeamBody)  # not before its package is read
    if signal.point is not None and known and len(signal.point) != expected:
        what = "x2, x3 of a beam" if expected == 2 else f"x, y, z of a {body.kind}"
        errors.append(f"{key}.point = {signal.point}: expected {expected} numbers, {what}")
    return errors


def without_strengths(key: str, body: BodySpec | None) -> list[str]:
    """Return an error at a key if the materials of a body are known, and none has strengths.

    Parameters
    ----------
    key : key of the input file and its value, for messages
    body : its specification, if there is one
    """
    content: Any = body.content if body else {}
    parts = [content[part] for part in ("shell", "solid", "section") if part in content]
    parts += [station["section"] for station in content.get("stations", [])]
    materials = {name: m for part in parts for name, m in part.get("materials", {}).items()}
    known = parts and all("materials" in part for part in parts)
    if not known or any("strength" in material for material in materials.values()):
        return []
    return [
        f"{key}: no material of it has strengths; expected a table "
        f"`strength` in {few(f'[materials.{name}]' for name in materials)} (docs/strength.md)"
    ]


def in_parts(
    mechanism: Mechanism, specs: BodySpecs
) -> tuple[Mechanism, dict[str, BodySpec], list[str]]:
    """Return the mechanism with divided beams, its flexible bodies, and one line per finding."""
    bodies, errors = cross_check(mechanism, specs)
    divided = mechanism if errors else in_segments(mechanism)
    if divided is not mechanism:
        bodies, errors = cross_check(divided, specs)
    return divided, bodies, errors
