"""Balances of a run, materials and packages of its bodies, and the strength of their plies."""

from collections.abc import Iterator
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dynamics.analysis.recovery import Recording
from ..dynamics.elements.forces.table import FORCES
from ..dynamics.elements.joints.contract import Angle, DrivenBy
from ..dynamics.elements.joints.table import JOINTS
from ..dynamics.evaluation.laws import law_at
from ..dynamics.model.model import AIR_DENSITY, RADIUS, SHEAR, UP
from ..integrators.generic import advice
from ..math.catalogue import Number
from ..math.rows import column
from ..package import ModalPackage
from ..package.common.plausible import (
    ANGLE,
    DEGREES,
    MATERIAL,
    Doubt,
    beam_doubts,
    body_doubts,
    described_doubts,
    gravity_doubts,
    not_allowed,
    rotor_doubts,
    section_doubts,
    shell_doubts,
)
from ..package.common.plausible import CODES as UNITS
from ..results.codes import (
    ANGLE_UNITS,
    CODES,
    CONSTRAINT_DRIFT,
    ENERGY_DRIFT,
    FEEDBACK,
    LOCKED,
    MATERIAL_UNITS,
    MOMENTUM,
    PLY_FAILURE,
    SIZE_UNITS,
    Finding,
)
from ..strength.strength_summary import BodyStrength, failure_text
from ..strength.weakest_plies import body_search
from .finished_run import FinishedRun

if TYPE_CHECKING:
    from ..inputs.case.tables.schema import Mechanism


def constraint_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield what the constraints make doubtful."""
    largest = run.past.position.value
    if largest > CONSTRAINT_DRIFT.limit:
        text = (
            f"joined points are up to {largest:.2g} m apart "
            f"(expected below {CONSTRAINT_DRIFT.limit:g} m): decrease rtol, or take "
            'constraints = "projection"'
        )
        yield CONSTRAINT_DRIFT.finding(text, t=run.past.position.t, value=largest)
    if run.degrees_of_freedom == 0:
        yield LOCKED.finding(
            "the mechanism has no degrees of freedom at t = 0: its bodies cannot move. Use "
            "flexible bodies, or joints that leave more freedom"
        )
    yield from _feedback(run)


def _feedback(run: FinishedRun) -> Iterator[Finding]:
    """Yield a note on a run whose steps the feedback of its constraints has kept short."""
    treatment, steps = run.treatment, run.solution.counters.steps
    rate = {
        "baumgarte": max(treatment.alpha, treatment.beta),
        "augmented-lagrangian": treatment.frequency * max(treatment.ratio, 1.0),
    }.get(treatment.name, 0.0)
    span = float(run.solution.t[-1])
    if steps < advice.STEPS_WORTH_A_LOOK or span == 0.0:
        return
    for text in advice.of_feedback(rate, span / steps, run.order):
        yield FEEDBACK.finding(text, value=rate * span / steps / run.order)


ROTOR_TIMES = 101  # at which wind and speed of a rotor are looked at
INSIDE = 0.1  # of the energy taken out of vibrations


def energy_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield a finding if energy less work drifts; a locked mechanism has none to balance."""
    largest = run.past.energy_drift
    # Inside a step, the state between two ends has lost another part than the whole step.
    between = INSIDE * abs(run.solution.damped_energy) / run.past.energy_in_play
    if largest <= ENERGY_DRIFT.limit + between or run.degrees_of_freedom == 0:
        return
    text = (
        f"the energy balance is off by {largest:.2g} of the energy "
        f"in play (expected below {ENERGY_DRIFT.limit:g}): decrease rtol"
    )
    yield ENERGY_DRIFT.finding(text, t=run.past.balance.t, value=largest)


def momentum_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield a finding if the reactions do not balance the change of momentum."""
    error = run.momentum_balance
    if error > MOMENTUM.limit:
        text = (
            "loads and reactions miss the change of momentum by "
            f"{error:.2g} of the largest force (expected below "
            f"{MOMENTUM.limit:g}): do not trust the reactions"
        )
        yield MOMENTUM.finding(text, value=error)


def material_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield materials and bodies whose numbers are unusual in SI units, a material once."""
    seen: set[str] = set()
    for body, doubt in _doubts(run):
        if doubt.code in run.mechanism.allow or doubt.text in seen:
            continue
        if doubt.code == MATERIAL:  # bodies share materials
            seen.add(doubt.text)
        code = MATERIAL_UNITS if doubt.code == MATERIAL else SIZE_UNITS
        named = body if body in run.built.body_names else ""
        yield code.finding(f"{body}: {doubt.text}", body=named, value=doubt.value)


def angle_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield angles in radians that are round numbers of degrees."""
    mechanism = run.mechanism
    for key, value in _angles(mechanism) if ANGLE not in mechanism.allow else ():
        if abs(value) in DEGREES:
            text = (
                f"{key} = {value:g} rad are {abs(value) / (2 * np.pi):.3g} turns: is it in rad, "
                "not in degrees?"
            )
            yield ANGLE_UNITS.finding(text, value=value)


def _angles(mechanism: "Mechanism") -> Iterator[tuple[str, float]]:
    """Yield the angles of forces and drives in radians, by their keys."""
    for name, force in mechanism.forces.items():
        units = ["rad"]
        if (joint := mechanism.joints.get(str(getattr(force, "joint", "")))) is not None:
            known = JOINTS[joint.kind].coordinates
            wanted = getattr(force, "coordinate", None) or known[0].name
            if any(isinstance(c, Angle) and c.name == wanted for c in known):
                units.append("m or rad")
        for key in getattr(FORCES[force.kind], "keys", ()):
            if isinstance(key, Number) and key.unit in units:
                value = getattr(force, key.name)
                yield from () if value is None else [(f"forces.{name}.{key.name}", float(value))]
    for name, joint in mechanism.joints.items():
        for own in JOINTS[joint.kind].keys:
            if isinstance(own, DrivenBy) and isinstance(own.drive.coordinate, Angle):
                law, key = getattr(joint, own.name), f"joints.{name}.{own.name}"
                if law is None:
                    continue
                if law.smooth_step is not None:
                    yield f"{key}.smooth_step.value", law.smooth_step.value
                if law.table is not None:
                    angles = np.abs(column(law.table.values))
                    if np.isin(angles, (0.0, *DEGREES)).all():  # others are those of a motion
                        yield f"{key}.table.values", float(angles.max())


def _doubts(run: FinishedRun) -> Iterator[tuple[str, Doubt]]:
    wholes = {name: getattr(body, "part_of", None) for name, body in run.mechanism.bodies.items()}
    for name, package in run.packages.items():
        spec = package.provenance.get("spec")
        parts = sum(whole == wholes[name] for whole in wholes.values()) if wholes[name] else 1
        for doubt in chain(_described(spec), _sized(package, spec, parts)):
            yield name, doubt
    for name, body in run.mechanism.bodies.items():
        if body.kind == "rigid":
            for doubt in body_doubts(body.mass, float(np.linalg.eigvalsh(body.inertia)[-1])):
                yield name, doubt
    for doubt in gravity_doubts(float(np.linalg.norm(run.mechanism.gravity))):
        yield "gravity", doubt
    if run.mechanism.rotor is not None:
        yield from (("rotor", doubt) for doubt in _of_rotor(run))


def _of_rotor(run: FinishedRun) -> Iterator[Doubt]:
    """Doubts about the rotor, at the times of `ROTOR_TIMES`."""
    model, (t, y) = run.model, run.at(ROTOR_TIMES)
    wind = max(abs(law_at(model, model.rotor.law[0], float(time))[0]) for time in t)
    strips = model.force_marker[model.rotor.section >= 0]
    recording = Recording(model, t, y)
    spin = recording.spin(int(strips[0, 0]))
    tip = float(model.rotor.numbers[RADIUS] * np.linalg.norm(spin, axis=1).max())
    up = model.rotor.numbers[UP : UP + 3]
    low = min(float((recording.position(int(k)) @ up).min()) for k in strips[:, 1])
    sheared = low if model.rotor.numbers[SHEAR] > 0.0 else 0.0
    yield from rotor_doubts(float(model.rotor.numbers[AIR_DENSITY]), wind, tip, sheared)


def _described(spec: Any) -> Iterator[Doubt]:
    """Doubts about all tables of materials of a specification, of its sections too."""
    if isinstance(spec, list):
        for item in spec:
            yield from _described(item)
    if isinstance(spec, dict):
        if isinstance(spec.get("materials"), dict):
            yield from not_allowed(spec, described_doubts(spec))
        for key, value in spec.items():
            if key != "materials":
                yield from _described(value)


def _sized(package: ModalPackage, spec: Any, parts: int) -> Iterator[Doubt]:
    """Doubts about the size of a shell or of a beam of equal parts; else about the mass alone."""
    mass = package.invariants.mass
    shell = spec.get("shell") if isinstance(spec, dict) else None
    if isinstance(shell, dict):
        yield from not_allowed(shell, shell_doubts(shell, package.nodes_B, mass))
        return
    # given matrices may belong to no shape
    shapes = [section for section in package.sections if section.recovery is not None]
    if shapes:
        length = parts * float(np.linalg.norm(np.diff(package.nodes_B, axis=0), axis=1).sum())
        spans = [np.ptp(section.recovery.points, axis=0) for section in shapes if section.recovery]
        width = max(float(np.linalg.norm(span)) for span in spans)
        yield from section_doubts(width, max(float(section.M[0, 0]) for section in shapes))
        yield from beam_doubts(width, length, mass)
    else:
        yield from body_doubts(mass)


def package_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield the warnings in the provenance of each package.

    A package from elsewhere may have codes of its own.
    """
    for name, package in run.packages.items():
        for item in package.provenance.get("warnings", []):
            if item["code"] in UNITS:  # of a section of the body: material_findings says it
                continue
            code, text = str(item["code"]), f"{name}: {item['message']}"
            known = CODES.get(code)
            yield known.finding(text, body=name) if known else Finding(code, text, name)


def body_strengths(run: FinishedRun) -> dict[str, BodyStrength]:
    """Return the strength of bodies with strengths, at the times of `look.strength`."""
    strengths = {}
    for i, name in enumerate(run.built.body_names):
        package = run.packages.get(name)
        if package is None:
            continue
        search = body_search(package)
        if search is None:
            continue
        for t, q in run.modes(i, run.look.strength):
            search.take(t, q)
        strength = search.found()
        if strength is not None:
            strengths[name] = strength
    return strengths


def strength_findings(strengths: dict[str, BodyStrength]) -> Iterator[Finding]:
    """Yield bodies of which a ply fails."""
    for name, strength in strengths.items():
        worst = strength.governing
        if worst.ratio < PLY_FAILURE.limit:
            text = failure_text(name, worst)
            yield PLY_FAILURE.finding(text, body=name, t=worst.time, value=worst.ratio)
