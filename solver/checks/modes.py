"""Checks of the vibration modes of bodies: enough of them, damping, elastic rotations."""

from collections.abc import Iterator
from math import ceil, tau
from typing import NamedTuple

import numpy as np

from ..dynamics.analysis.quasi_static import vibrations
from ..dynamics.analysis.rank import free_motions
from ..dynamics.analysis.recovery import stiffened
from ..dynamics.evaluation.accelerations import assemble
from ..dynamics.tolerances import WITHOUT_STRAIN
from ..inputs.case.record import loaded_places
from ..package import ModalPackage
from ..results.codes import CUT_EARLY, ROTATION, Finding
from .finished_run import FinishedRun
from .statics import missing_findings
from .tolerances import OF_ONE_BODY

# Whether the vibration modes of each body are enough, family by family.

VIBRATION = ("fixed_normal", "experimental")  # kinds of modes, of package.schema.MODE_KINDS
# Directions of the loads that deform a beam as the vibrations of a family do.
DIRECTIONS = {
    "bending-xy": ("y", "rz"),
    "bending-xz": ("z", "ry"),
    "torsion": ("rx",),
    "axial": ("x",),
}
# Strain energy of the second mode over that of the first, of a uniform cantilever under a load at
# its end: (omega_1 / omega_2)^2. One mode alone does not show how fast its series converges.
SECOND = {"bending-xy": 0.0255, "bending-xz": 0.0255, "torsion": 1.0 / 9.0, "axial": 1.0 / 9.0}


class _Family(NamedTuple):
    """Vibrations of one kind, in the order of their frequencies."""

    name: str
    rows: list[int]

    def words(self) -> str:
        """Return what its highest mode is called in a message."""
        kind = f"{self.name} " if self.name else ""
        if len(self.rows) == 1:
            return f"a second {kind}vibration mode would carry about"
        return f"the highest of {len(self.rows)} {kind}vibration modes carries"


def mode_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield bodies that vibrate in the highest of their modes: those above it are not there.

    The highest mode of each family is looked at: its largest kinetic energy over the largest strain
    energy of the body. What a load strains slowly is judged by the compliance (statics.py). Of a
    package without one, the strain energy of the highest mode counts, too, at the instant at which
    the family has most, unless there are static shapes of these loads.

    None of a run with `[fidelity]`: its estimated errors show what other modes would change.
    """
    if run.mechanism.fidelity is not None:
        return
    yield from missing_findings(run)
    for i in np.flatnonzero(run.model.n_mode[: len(run.built.body_names)] > 1).tolist():
        name = run.built.body_names[i]
        package = run.packages[name]
        peak, ranges = 0.0, {family.name: (family, 0.0, 0.0, 0.0) for family in _families(package)}
        stiffness, mass = np.diag(package.stiffness), np.diag(package.mass)
        m, a = int(run.model.n_mode[i]), int(run.model.pos_start[i]) + 7
        b = run.model.n_pos + int(run.model.vel_start[i]) + 6
        for _, y in run.blocks():
            q, rate = y[:, a : a + m], y[:, b : b + m]
            strain, moving = 0.5 * stiffness * q**2, 0.5 * mass * rate**2
            peak = max(peak, float(strain.sum(axis=1).max()))
            for key, (family, most, slow, fast) in ranges.items():
                energy = strain[:, family.rows].sum(axis=1)
                at, last = int(np.argmax(energy)), family.rows[-1]
                if energy[at] > most:
                    most, slow = float(energy[at]), float(strain[at, last])
                ranges[key] = family, most, slow, max(fast, float(moving[:, last].max()))
        for family, _, slow, fast in ranges.values():
            bare = _without_static_shapes(run, name, package, family)
            part = SECOND.get(family.name, 0.0) if len(family.rows) == 1 else 1.0
            strained = slow if bare and package.compliance is None else 0.0
            share = part * max(strained, fast) / peak if peak > 0.0 else 0.0
            if share > CUT_EARLY.limit:
                advice = "take more modes"
                if strained > fast and "experimental" not in package.mode_kinds:
                    advice += f', or modes of kind "attachment" at {", ".join(bare)}'
                text = (
                    f"{name}: {family.words()} {share:.1%} of the peak strain energy "
                    f"(expected below {CUT_EARLY.limit:.0%}): {advice}"
                )
                yield CUT_EARLY.finding(text, body=name, value=share)


def _families(package: ModalPackage) -> list[_Family]:
    """Group the vibrations by their labels without the number, or by the axis of their motion.

    Labels of measured modes are those of the user, and those of other bodies name no family.
    """
    rows: dict[str, list[int]] = {}
    energies = np.einsum("aakk->ka", package.invariants.T11_B)  # of a mode, along the axes
    for k, kind in enumerate(package.mode_kinds):
        if kind in VIBRATION:
            label = package.mode_labels[k] if package.mode_labels else ""
            family = label.rpartition(" ")[0]
            if kind == "experimental" or family not in DIRECTIONS:
                turns = energies[k].sum() < 0.5 * package.mass[k, k]
                family = (
                    "rotational" if turns else f"{'xyz'[int(np.argmax(energies[k]))]}-direction"
                )
            rows.setdefault(family, []).append(k)
    return [_Family(name, members) for name, members in rows.items()]


def _without_static_shapes(
    run: FinishedRun, name: str, package: ModalPackage, family: _Family
) -> list[str]:
    """Return the loaded places that a family moves and that have no static shapes of it."""
    covered = set()
    for label, kind in zip(package.mode_labels, package.mode_kinds, strict=False):
        if kind not in VIBRATION:
            _, place, direction = (*label.split(" "), "", "")[:3]
            if direction in DIRECTIONS.get(family.name, (direction,)):
                covered.add(place)
    moved = {
        one.name
        for one in package.interfaces
        if one.phi_B[:, family.rows].any() or one.psi_B[:, family.rows].any()
    }
    return [p for p in loaded_places(name, run.mechanism) if p in moved and p not in covered]


# Whether modal damping means in the mechanism what it means for the body by itself.

MOST = 400  # velocity coordinates: the eigenproblem of more would be felt


def loaded_damping(run: FinishedRun) -> list[dict[str, object]]:
    """Return, of each damped body, its damping ratio in the mechanism and by itself.

    Entries: `body`; `frequency_hz` and `damping_ratio` of the lowest vibration of the mechanism
    that is one of the body (more than a quarter of the strain energy); `own_frequency_hz` and
    `own_damping_ratio` of the mode that has most of it, of the body by itself. Vibrations are those
    of the mechanism at the start: elastic bodies with their joints and masses, drives held, without
    springs, weight and spin. Empty above 400 velocity coordinates.
    """
    packages, names = run.packages, run.built.body_names
    damped = [
        i for i, name in enumerate(names) if name in packages and packages[name].damping.any()
    ]
    if not damped or run.model.n_vel > MOST:
        return []
    equations = assemble(run.model, float(run.solution.t[0]), run.solution.y[0])
    Z = free_motions(equations, run.model.inertia_scale).Z
    try:
        _, values, shapes = vibrations(run.model, Z, equations.M)
    except np.linalg.LinAlgError:  # a free motion moves no mass
        return []
    elastic = values > WITHOUT_STRAIN * values[-1]
    omega, shapes = np.sqrt(values[elastic]), shapes[:, elastic]
    entries = []
    for i in damped:
        package = packages[names[i]]
        j = int(run.model.vel_start[i]) + 6
        q = shapes[j : j + package.n_mode]
        share = np.einsum("ak,ak->k", q, package.stiffness @ q) / omega**2
        of_body = np.flatnonzero(share > OF_ONE_BODY)
        if not of_body.size:
            continue
        k = int(of_body[0])  # the lowest
        mode = int(np.argmax(q[:, k] ** 2 * np.diag(package.stiffness)))
        if not package.damping[mode, mode]:
            continue
        own = float(package.damping[mode, mode] / (2.0 * package.frequencies[mode]))
        loaded = float(q[:, k] @ package.damping @ q[:, k]) / (2.0 * float(omega[k]) * share[k])
        entries.append(
            {
                "body": names[i],
                "frequency_hz": float(omega[k]) / (2.0 * np.pi),
                "damping_ratio": float(loaded),
                "own_frequency_hz": float(package.frequencies[mode]) / (2.0 * np.pi),
                "own_damping_ratio": own,
            }
        )
    return entries


# Elastic rotations: how far interfaces turn relative to the frame of their body.

UNEVEN = 1.2  # of segments: rotation of the one that bends most, against that of equal bending


def motion_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield bodies whose interfaces turn too far for small elastic rotations.

    Of a body in segments, the segment that turns most stands for all.
    """
    worst: dict[str, tuple[float, str, int]] = {}  # body of the case: rotation, its part, index
    segments: dict[str, int] = {}
    for i, name in enumerate(run.built.body_names):
        body = run.mechanism.bodies.get(name)
        whole = getattr(body, "part_of", None) or name
        if body is not None and body.kind == "beam":
            segments[whole] = segments.get(whole, 0) + 1
        if not run.model.n_mode[i]:
            continue
        rotation = max(
            float(np.max(np.linalg.norm(q @ interface.psi_B.T, axis=1)))
            for _, q in run.modes(i)
            for interface in run.packages[name].interfaces
        )
        if rotation > worst.get(whole, (ROTATION.limit,))[0]:
            worst[whole] = rotation, name, i
    for whole, (rotation, name, i) in worst.items():
        count = segments.get(whole, 0)
        frame = run.better_frame(name) if stiffened(run.model, i) else None
        text = _text(whole, name, rotation, count, frame)
        yield ROTATION.finding(text, body=whole, value=rotation)


def _text(whole: str, name: str, rotation: float, count: int, frame: str | None) -> str:
    """Return the message; `count` is the number of segments of a beam, 0 of another body.

    `frame` is advice on that of a second-order body, None of a linear one.

    The rotation relative to the frame of a segment is about inverse to their number; that of the
    segment in which a beam bends most falls a little more slowly. A rotation above a full turn, of
    displacements without meaning, says nothing of the number.
    """
    part = f" of segment {name}" if count > 1 else ""
    turn = f"{whole}: an interface{part} turns by {rotation:.2f} rad relative to the body frame "
    limit = f"below {ROTATION.limit:g} rad"
    if rotation > tau:
        limit += "; this result is invalid"
    split = "model the part as several bodies with fixed joints between them"
    if count:
        now = f" ({count} now)" if count > 1 else ""
        number = ceil((UNEVEN if count > 1 else 1.0) * count * rotation / ROTATION.limit)
        wanted = f" = {number}" if rotation <= tau else ""
        split = f"divide the beam by segments{wanted}{now}"
    if frame is not None:
        accuracy = "expect an error of about 2 % at 0.25 rad"
        return f"{turn}(second-order body: {limit}; {accuracy}): {frame}{split}"
    if count:
        split += ", with solver.geometric_stiffening = true"
    return f"{turn}(linear bodies: {limit}): {split}, or stiffen it"
