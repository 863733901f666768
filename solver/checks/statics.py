"""What the modes of a body miss of its static deformation under the loads of a run.

A package has the compliance C of the whole body: p' C p is twice the strain energy of its static
deformation under loads p, those at its interfaces and A [x; 1] dm of the moving frame. With the
motions F (l, m) of the places of these loads in the modes, the modes have p' F K^-1 F' p of it.
This is less, because the static deformation makes the total energy least among all shapes that
fulfil the reference condition:

    U_missing = 1/2 p' (C - F K^-1 F') p

Loads p have no inertia of the vibrations, so that U_missing does not ring with them. A shape under
a unit load e_i reduces the missing compliance G to G - G e_i e_i' G / G_ii: it shows which static
shapes help, before they are there.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..dynamics.analysis.recovery import Recording, body_frames
from ..dynamics.evaluation import series
from ..errors import few
from ..math.arrays import Array
from ..math.rotations import skew
from ..mechanism.built_mechanism import BuiltMechanism
from ..package import ModalPackage
from ..package.body.invariants import body_size
from ..results.codes import FEW_MODES, WITH_DATA, Finding
from .finished_run import FinishedRun
from .tolerances import LOAD_ROUNDING, OVERSHOOT, SLIGHT, SMALL_LOAD, STRAIGHT

WINDOWS, WIDTH = 6, 9  # how many are looked at, and outputs in each
AXES = ("x", "y", "z", "rx", "ry", "rz")
MORE = {"x": "axial", "y": "bending-xy", "z": "bending-xz"}  # of a beam, by its main motion
INERTIA = 12  # loads A [x; 1] dm, by rows of A (3, 4)


def missing_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield flexible bodies whose modes miss much of the static deformation under their loads.

    Of a body in segments, what a segment misses is a share of the largest deformation of one: at
    a free end it is most of the little that its own inertia makes there, with any number of them.

    Packages without a compliance are not judged, see `unjudged_hints`.
    """
    packages = {
        i: run.packages[name]
        for i, name in enumerate(run.built.body_names)
        if run.model.n_mode[i] and run.packages[name].compliance is not None
    }
    if not packages or any(finding.level == "error" for finding in run.noticed):
        return
    # The first state, and windows of neighbouring outputs: the mean of a window is the slow part
    # of a load, as static shapes of joints vibrate fast.
    count = run.solution.t.size
    width = min(WIDTH, count)
    windows = max(1, min(WINDOWS, count // width))
    begin = np.linspace(0, count - width, windows).astype(int)
    rows = np.append(0, (begin[:, None] + np.arange(width)).ravel())
    recording = Recording(run.model, run.solution.t[rows], run.solution.y[rows])
    parts = {i: _missing(run, i, package, recording, windows) for i, package in packages.items()}
    names, bodies = run.built.body_names, run.mechanism.bodies
    wholes = {i: getattr(bodies.get(names[i]), "part_of", None) or names[i] for i in parts}
    most: dict[str, float] = {}  # strain energy of the segment of a beam that has most of it
    for i, part in parts.items():
        most[wholes[i]] = max(part.energy, most.get(wholes[i], 0.0))
    for i, part in parts.items():
        missing = part._replace(share=part.share * part.energy / (most[wholes[i]] or 1.0))
        if missing.share > FEW_MODES.limit:
            name, package = names[i], packages[i]
            yield FEW_MODES.finding(
                missing.text(name, package), body=name, t=missing.t, value=missing.share
            )


def unjudged_hints(run: FinishedRun) -> list[str]:
    """Return remarks on the flexible bodies whose packages lack what a check needs.

    Those of modes alone, and of earlier versions, have no compliance: mass stations and modes do
    not show what the modes miss. Without second-order data, spin and forces along it are judged.
    """
    flexible = {n: p for n, p in run.packages.items() if p.n_mode}
    bare = [n for n, p in flexible.items() if p.compliance is None]
    asked = run.mechanism.solver.geometric_stiffening  # it is a warning then
    linear = [n for n, p in flexible.items() if p.second_order is None and not asked]
    hints = []
    if bare:
        hints.append(
            f"not judged: whether the modes of {few(bare)} carry the loads of the run "
            "(modes-too-few); packages of earlier versions and of modes alone have no compliance: "
            "build them again"
        )
    if linear:
        hints.append(
            f"not judged: whether moments and forces across stiffen or buckle {few(linear)} "
            "(stiffening-matters, buckling-load), because their packages have no second-order "
            f"data. {WITH_DATA}"
        )
    return hints


def unit_motions(package: ModalPackage) -> Array:
    """Return the motion (l, m) of the place of each unit load of the compliance, by mode."""
    inv = package.invariants
    own = [np.vstack([one.phi_B, one.psi_B]) for one in package.interfaces]
    inertia = np.concatenate([np.moveaxis(inv.T01_B, 1, 0), inv.S_B[:, None]], axis=1)
    turn = np.cross(np.eye(3), np.eye(3)[:, None])  # [a, b] e_b x e_a, twice the rotation of x_b
    inertia[:, :3] += 0.5 * turn @ inv.J_psi_B
    return np.vstack([*own, inertia.reshape(INERTIA, -1)])


class _Missing(NamedTuple):
    """What the modes miss: a share of the strain energy [J], and loads p (l,) at an instant t [s].

    `mean` (l, l) is the mean of p p', of the start and of the run where they miss much; `G` and
    `C` (l, l) are the missing and the whole compliance.
    """

    share: float
    energy: float
    t: float
    p: Array
    mean: Array
    G: Array
    C: Array

    def text(self, name: str, package: ModalPackage) -> str:
        """Return the message: the share, a displacement, and the shapes that carry the load."""
        places = [one.name for one in package.interfaces]
        work = self.p * (self.G @ self.p)
        k = int(np.argmax(work))
        whole = float(self.C[k] @ self.p)
        carried = whole - float(self.G[k] @ self.p)
        if k < 6 * len(places):
            place, axis = places[k // 6], AXES[k % 6]
            of, moves, unit = ("N m", "turns", "rad") if "r" in axis else ("N", "moves", "m")
            load = f"{self.p[k]:.3g} {of} ({axis}) at {place} {moves} it"
        else:
            axis = AXES[(k - 6 * len(places)) // 4]
            k = 6 * len(places) + 4 * AXES.index(axis) + 3
            mass = package.invariants.mass
            whole, carried = (
                float(row @ self.p) / mass for row in (self.C[k], self.C[k] - self.G[k])
            )
            load, unit = f"weight and inertia move the body along {axis}, in the mean,", "m"
        floor = LOAD_ROUNDING * max(abs(whole), abs(carried))
        whole, carried = (v if abs(v) > floor else 0.0 for v in (whole, carried))
        return (
            f"{name}: the modes miss about {self.share:.0%} of the static deformation (strain "
            f"energy) under the loads of the run (expected below {FEW_MODES.limit:.0%}). At "
            f"t = {self.t:.3g} s {load} by {whole:.3g} {unit} in equilibrium and by {carried:.3g} "
            f"{unit} with the modes. Take {', '.join(self.advice(package))}"
        )

    def advice(self, package: ModalPackage) -> list[str]:
        """Return the shapes, the most useful first, that leave less than half of the limit."""
        G, places = self.G, [one.name for one in package.interfaces]
        whole = np.diag(self.mean) * np.diag(self.C)
        acts = whole > SMALL_LOAD * whole.max()
        enough = 0.5 * FEW_MODES.limit * float(np.sum(G * self.mean)) / self.share
        shapes: dict[str, list[str]] = {}
        n = 6 * len(places)
        while float(np.sum(G * self.mean)) > enough:
            own = np.diag(G)
            able = acts & (own > SLIGHT * np.diag(self.C))
            gain = np.where(able, np.diag(G @ self.mean @ G) / np.where(able, own, 1.0), 0.0)
            k = int(np.argmax(gain[:n])) if n else 0
            if not n or gain[k] <= 0.5 * np.max(gain[n:]):
                break
            shapes.setdefault(places[k // 6], []).append(AXES[k % 6])
            G = G - np.outer(G[k], G[k]) / G[k, k]
        advice = [f'modes of kind "attachment" at {at} ({" ".join(d)})' for at, d in shapes.items()]
        if not advice or float(np.sum(G * self.mean)) > enough:
            work = np.diag(G @ self.mean)[n:].reshape(3, 4)
            turns = {"torsion": work[1, 2] + work[2, 1]} if package.sections else {}
            across = zip(AXES, work.sum(axis=1) - [0.0, work[1, 2], work[2, 1]], strict=False)
            kinds = turns | {MORE[a] if package.sections else f"along {a}": w for a, w in across}
            advice.append(f"more vibration modes ({max(kinds, key=lambda kind: kinds[kind])})")
        return advice


def _missing(
    run: FinishedRun, body: int, package: ModalPackage, recording: Recording, windows: int
) -> _Missing:
    """Return what the modes of a body miss, in the mean over windows or at a start at rest."""
    p, C = _loads(run.built, body, package, recording), package.compliance
    assert C is not None  # of every package that is judged
    G = missing_compliance(package, C)
    q = recording.modes(body)[1:]
    vibration = 0.5 * float(np.mean(np.sum((q @ package.stiffness) * q, axis=1))) / OVERSHOOT
    n = len(C) - INERTIA
    # A straight beam without modes along x is not judged for loads along x: a slender beam
    # hardly stretches, so that its users leave these modes out.
    lateral = package.nodes_B[:, 1:]
    straight = package.sections and np.ptp(lateral, axis=0).max() <= STRAIGHT * body_size(package)
    axial = ("axial" in label or label.endswith(" x") for label in package.mode_labels)
    largest = 0.5 * float(np.max(np.sum((p @ C) * p, axis=1)))
    if straight and not any(axial):
        p[:, [*range(0, n, 6), *range(n, n + 4)]] = 0.0
    forces = np.arange(n).reshape(-1, 3)
    inertia = n + np.arange(INERTIA).reshape(3, 4)
    kinds = [*forces, inertia[:, 3], inertia[:, :3].ravel()]  # of one unit each
    softest = np.array([np.linalg.eigvalsh(C[np.ix_(rows, rows)])[-1] for rows in kinds])
    # What varies fast counts for the size of loads: the mean of slow parts may be below zero.
    slow = [(p[1:], *_slow(p[1:], windows), _means(recording.t[1:], windows))]
    if run.mechanism.solver.start != "positions":  # whose loads may be released then
        slow.append((p[:1], p[:1, :, None] * p[:1, None], p[:1], recording.t[:1]))
    missed = np.zeros_like(C)
    worst, energy = _Missing(0.0, 0.0, 0.0, p[0], missed, G, C), 0.0
    for loads, squares, means, t in slow:
        mean, size = squares.mean(axis=0), np.mean(loads**2, axis=0)
        whole = 0.5 * max(float(np.sum(C * mean)), 0.0)
        # Each kind of loads by itself: the inertia of a spin is large along the body, hardly
        # strains it, and says nothing of what weight misses across it.
        counted = np.zeros(len(C), dtype=bool)
        for rows, soft in zip(kinds, softest, strict=True):
            own = np.ix_(rows, rows)
            counted[rows] = np.sum(G[own] * mean[own]) > SLIGHT * soft * size[rows].sum()
        lost = 0.5 * max(float(np.sum((G * mean)[np.ix_(counted, counted)])), 0.0)
        energy = max(energy, whole, vibration)
        share = lost / max(whole, vibration) if lost > LOAD_ROUNDING**2 * largest else 0.0
        missed = missed + mean if share > FEW_MODES.limit else missed
        if share > worst.share:
            k = int(np.argmax([float(a @ G @ a) for a in means]))
            worst = _Missing(share, 0.0, float(t[k]), means[k], mean, G, C)
    return worst._replace(mean=missed, energy=energy)


def missed_by_modes(
    built: BuiltMechanism, motions: Sequence[tuple[int, Recording, float]]
) -> Iterator[str]:
    """Yield bodies whose own modes miss much of their deformation in modes of the mechanism.

    Parameters
    ----------
    built : bodies of the mechanism
    motions : number of a mode, four states a quarter of its period apart with a small amplitude,
        and its mean potential energy [J]. The square of its frequency falls by what is missed
    """
    for i, name in enumerate(built.body_names):
        package = built.packages.get(name)
        if package is None or package.compliance is None or not built.model.n_mode[i]:
            continue
        G, shares = missing_compliance(package, package.compliance), {}
        sums = np.zeros_like(G)
        for number, states, energy in motions:
            p = _loads(built, i, package, states)
            p = 0.5 * (p[:2] - p[2:])
            mean = 0.5 * p.T @ p / energy
            share = 0.5 * float(np.sum(G * mean))  # of the energy with the modes
            if share > FEW_MODES.limit:
                sums, shares[number] = sums + mean, share
        if shares:
            worst = max(shares, key=lambda number: shares[number])
            part = shares[worst] / (1.0 + shares[worst])
            whole = 0.5 * float(np.sum(G * sums))
            missing = _Missing(whole, 0.0, 0.0, p[0], sums, G, package.compliance)
            yield (
                f"{'modes' if len(shares) > 1 else 'mode'} {few([str(k) for k in shares])}: "
                f"frequencies too high (mode {worst} by about "
                f"{math.sqrt(1.0 + shares[worst]) - 1.0:.0%}): the modes of {name} miss "
                f"{part:.0%} of the strain energy of this mode. Take "
                f"{', '.join(missing.advice(package))}"
            )


def missing_compliance(package: ModalPackage, C: Array) -> Array:
    """Return the compliance (l, l) that the modes of a package lack of its whole one, C (l, l)."""
    F = unit_motions(package)
    return np.asarray(C - F @ np.linalg.solve(package.stiffness, F.T))


def _loads(built: BuiltMechanism, body: int, package: ModalPackage, recording: Recording) -> Array:
    """Return the loads p (k, l) on a body, in its axes."""
    model = recording.model
    _, A, _ = body_frames(model, body, recording.y)
    j = model.n_pos + int(model.vel_start[body])
    w = np.array([skew(each) for each in recording.y[:, j + 3 : j + 6]])
    w_d = np.array([skew(each) for each in recording.rates[:, j + 3 : j + 6]])
    falls = np.einsum("kba,kb->ka", A, model.gravity_G - recording.rates[:, j : j + 3])
    inertia = np.concatenate([-w_d - w @ w, falls[:, :, None]], axis=2)
    places = np.array([one.position_B for one in package.interfaces]).reshape(-1, 3)
    forces = np.zeros((len(A), len(places), 2, 3))
    loaded = series.loaded_markers(model)
    acting = [
        (int(marker), recording.loads([number])[:, 0].reshape(-1, 2, 3))
        for number, marker in enumerate(loaded.tolist())
        if model.marker_body[marker] == body
    ]
    for marker, mass in built.point_masses:
        if model.marker_body[marker] == body:
            force = mass * (model.gravity_G - recording.acceleration(marker))
            acting.append((marker, np.stack([force, np.zeros_like(force)], axis=1)))
    for marker, load in acting:
        at = int(np.argmin(np.abs(places - model.marker_x[marker]).sum(axis=1)))
        forces[:, at] += np.einsum("kba,kcb->kca", A, load)
    return np.hstack([forces.reshape(len(A), -1), inertia.reshape(len(A), -1)])


def _means(values: Array, windows: int) -> Array:
    """Return the means over windows, of values (k, ...)."""
    return np.asarray(values.reshape(windows, -1, *values.shape[1:]).mean(axis=1))


def _slow(p: Array, windows: int) -> tuple[Array, Array]:
    """Return p p' (n, l, l) of the slow part of loads p (k, l), by window, and p.

    Of what varies at random in a window of w values, 1/w of the square is left in their mean.
    """
    means, w = _means(p, windows), len(p) // windows
    squares = means[:, :, None] * means[:, None]
    if w > 1:
        squares = (w * squares - _means(p[:, :, None] * p[:, None], windows)) / (w - 1.0)
    return squares, means
