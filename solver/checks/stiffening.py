"""Bodies that lose their stiffness under load, and linear bodies that should have been stiffened.

A stiffened body whose elastic and geometric stiffness together have lost an eigenvalue buckles; a
linear body whose geometric stiffness is not small should have been stiffened.
"""

from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np

from ..dynamics.analysis.rank import free_motions
from ..dynamics.analysis.recovery import extent, sizes_of_motion, stiffened
from ..dynamics.elements.floating_frame import stiffening_matrices
from ..dynamics.evaluation import series
from ..dynamics.evaluation.accelerations import assemble
from ..dynamics.evaluation.series import mass_matrices
from ..dynamics.model.model import Model, modal_matrix
from ..math.arrays import Array, distinct
from ..math.rotations import rotation_matrices
from ..mechanism.build import build
from ..results.codes import (
    BUCKLING,
    BUCKLING_LOAD,
    INDEFINITE,
    MATTERS,
    NO_STIFFENING_DATA,
    ROTATION,
    SPIN,
    TILTING,
    UNDISTURBED,
    WITH_DATA,
    Finding,
)
from .finished_run import FinishedRun
from .stability import (
    Loading,
    SpinMonitor,
    buckling_text,
    elastic_motions,
    geometric_stiffness,
    joints_hold,
)
from .tolerances import FREE_MODE, SLIGHT, WHIRLS

LOOKS, WIDEST = 11, 250  # of a run for unstable motions, and of velocity coordinates for one
BUCKLED = {SPIN.name, BUCKLING.name, BUCKLING_LOAD.name}
SLICES = 12  # of a body without second-order data
MOST_FREE = 41  # states of which the mass of free motions is computed, a dense problem


def stiffening_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield stiffened bodies in doubt, and linear ones that should be stiffened."""
    asked = run.mechanism.solver.geometric_stiffening
    if asked:
        for name, package in run.packages.items():
            if package.second_order is None and package.n_mode:
                text = (
                    f"{name}: geometric_stiffening was asked for, but the package of the body has "
                    f"no second-order data: the body stays linear. {WITH_DATA}"
                )
                yield NO_STIFFENING_DATA.finding(text, body=name)
    spin = SpinMonitor(run.model, run.built.body_names, stop=False)
    loading = Loading(run.model)
    for i, name in enumerate(run.built.body_names):
        if i in spin.safe_spin and run.packages[name].second_order is None:
            found = [*_of_spin(run, i, spin.safe_spin[i])]
            yield from found or _of_pull(run, i, loading)
    if all(package.second_order is None for package in run.packages.values()):
        return
    again = None if asked else build(run.mechanism, dict(run.packages), stiffening=True)
    tables = again.model if again else run.model
    for i, name in enumerate(run.built.body_names):
        if name not in run.packages or run.packages[name].second_order is None:
            continue
        if stiffened(run.model, i):
            yield from _of_stiffened(run, i, loading, spin)
        else:
            yield from _of_linear(run, tables, i, loading, spin)


def undisturbed_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield the elastic motion that loads have made unstable, and that nothing has begun.

    A straight column above its buckling load stays straight without an imperfection. A body tells
    so by its own stiffness (BucklingMonitor), several that are joined to a column do not. Counted
    is how much a deflection would have grown while there is none above SLIGHT of the size.
    """
    model, times, bodies = run.model, run.solution.t, run.mechanism.bodies
    known = any(finding.code in BUCKLED for finding in run.noticed)
    known = known or run.solution.status == "failed"
    if known or not model.n_mode.any() or model.n_vel > WIDEST:
        return
    growth, looks = 0.0, run.some(LOOKS).tolist()

    def stable(K: Array) -> bool:
        return not K.size or float(np.linalg.eigvalsh(K + K.T)[0]) >= 0.0

    # Few looks first, the last among them: a look takes 0.4 ms, and most runs are stable.
    few = (elastic_motions(model, float(times[k]), run.solution.y[k]) for k in looks[:0:-4])
    if all(stable(K) for _, _, K, _ in few):
        return
    for last, k in pairwise(looks):
        t, y = float(times[k]), run.solution.y[k]
        Z, M, K, C = elastic_motions(model, t, y)
        if stable(K):
            growth = 0.0
            continue
        state = -np.linalg.solve(M, np.hstack([K, C]))
        rates, shapes = np.linalg.eig(np.vstack([np.eye(len(M), 2 * len(M), len(M)), state]))
        fastest = int(np.argmax(rates.real))
        rate, shape = float(rates[fastest].real), Z @ shapes[: len(M), fastest].real
        work, energy = np.zeros(model.n_body), np.zeros(model.n_body)
        for i in np.flatnonzero(model.n_mode).tolist():
            m, a = int(model.n_mode[i]), int(model.pos_start[i]) + 7
            own = shape[int(model.vel_start[i]) + 6 :][:m]
            load = modal_matrix(model, model.K_qq, i) @ own
            work[i], energy[i] = load @ y[a : a + m], load @ own
        size = np.abs(shape / sizes_of_motion(model, extent(model, y))).max()
        moved = abs(work.sum()) / energy.sum() * size
        growth = growth + rate * float(times[k] - times[last]) if moved < SLIGHT else 0.0
        if growth > UNDISTURBED.limit:
            name = run.built.body_names[int(np.argmax(energy))]
            whole = getattr(bodies.get(name), "part_of", None) or name
            text = (
                f"{whole}: at t = {t:.4g} s the loads are above a buckling load of the mechanism, "
                f"and no motion has begun: a deflection would grow e-fold in {1.0 / rate:.2g} s, "
                "and there is none, as in a perfectly straight column. Give it an imperfection: a "
                "small load across, such as a thousandth of the load, or a line that is not "
                "straight"
            )
            yield UNDISTURBED.finding(text, body=whole, t=t, value=growth)
            return


def _of_spin(run: FinishedRun, i: int, frequency: float) -> Iterator[Finding]:
    """Yield a body without second-order data whose geometric stiffness by its spin is not small.

    Its size relative to the elastic stiffness is (spin / frequency)^2 of a rod that spins across
    its axis, and none of one that spins about it: by the work of the centrifugal forces on the
    body's own extent. Other loads than those of the spin are not looked at.

    Parameters
    ----------
    i : number of the body
    frequency : lowest of the body in its frame [rad/s]
    """
    name, model = run.built.body_names[i], run.model
    of_body = run.packages[name].invariants
    C = of_body.T00_B - np.outer(of_body.S0_B, of_body.S0_B) / of_body.mass  # about the centre
    first = model.n_pos + int(model.vel_start[i]) + 3
    stretch = np.eye(3) - C / np.trace(C)

    def share(_t: Array, y: Array) -> Array:
        w = y[:, first : first + 3]
        return np.einsum("ka,ab,kb->k", w, stretch, w) / frequency**2

    return _without_data(run, name, "body's spin", share)


def _without_data(
    run: FinishedRun, name: str, what: str, share: Callable[[Array, Array], Array]
) -> Iterator[Finding]:
    """Yield a body without second-order data whose `share` of geometric stiffness is not small.

    Parameters
    ----------
    name : of the body
    what : loads whose geometric stiffness it is
    share : over the elastic stiffness, at times (k,) and states (k, n)
    """
    t, values = run.scan(share, run.look.stiffening)
    k = int(np.argmax(values))
    if values[k] > MATTERS.limit:
        text = (
            f"{name}: at t = {t[k]:.4g} s the geometric stiffness of the {what} is about "
            f"{values[k]:.2g} of its elastic one (a linear body neglects it: expected below "
            f"{MATTERS.limit:g}), and its package has no second-order data. {WITH_DATA}"
        )
        yield MATTERS.finding(text, body=name, t=float(t[k]), value=float(values[k]))


def _of_pull(run: FinishedRun, i: int, loading: Loading) -> Iterator[Finding]:
    """Yield a body without second-order data whose forces along it stiffen or soften it.

    The body is taken for a string along its longest axis, between slices that have the mean
    displacements of their nodes. The force in it is that at the places beyond, with weight and
    inertia there. Moments and forces across are not looked at.
    """
    model, package = run.model, run.packages[run.built.body_names[i]]
    nodes = package.nodes_B
    axis = np.linalg.svd(nodes - nodes.mean(axis=0), full_matrices=False)[2][0]
    along = nodes @ axis
    begin, length = along.min(), np.ptp(along) or 1.0
    number = np.minimum((along - begin) / length * SLICES, SLICES - 1).astype(int)
    slices = [np.flatnonzero(number == k) for k in distinct(number)]
    middle = np.array([along[part].mean() for part in slices])
    u = np.array([package.shapes_B[:, part, :3].mean(axis=1) for part in slices])
    between, h = 0.5 * (middle[1:] + middle[:-1]), np.diff(middle)
    turn = np.diff(u, axis=0)
    turn = turn - (turn @ axis)[..., None] * axis
    unit = np.einsum("cia,cja->cij", turn, turn) / h[:, None, None]  # of N = 1 between two slices
    mass = np.array([package.node_mass[along > s].sum() for s in between])
    markers = series.loaded_markers(model)
    own = np.flatnonzero(model.marker_body[markers] == i)
    beyond = (model.marker_x[markers[own]] @ axis)[:, None] > between
    a, j = int(model.pos_start[i]) + 3, model.n_pos + int(model.vel_start[i])
    scale = np.linalg.inv(np.linalg.cholesky(package.stiffness))
    unit = scale @ unit @ scale.T

    def share(t: Array, y: Array) -> Array:
        rates, loads = loading(t, y)
        e = rotation_matrices(y[:, a : a + 4]) @ axis
        N = np.einsum("kla,ka,lc->kc", loads[:, own, :3], e, beyond)
        N -= np.einsum("ka,ka,c->kc", rates[:, j : j + 3] - model.gravity_G, e, mass)
        return np.abs(np.linalg.eigvalsh(np.einsum("kc,cij->kij", N, unit))).max(axis=1)

    return _without_data(run, run.built.body_names[i], "forces along it", share)


def _of_stiffened(
    run: FinishedRun, i: int, loading: Loading, spin: SpinMonitor
) -> Iterator[Finding]:
    """Yield the first instants at which mass or stiffness of a stiffened body is not positive.

    The stiffness along a run is looked at during it, where a loss must last to count
    (BucklingMonitor); here that of states alone.
    """
    model, name = run.model, run.built.body_names[i]

    def negative_mass(t: Array, y: Array) -> Array:
        M = mass_matrices(model, i, t, y)
        scale = 1.0 / np.sqrt(np.abs(np.einsum("kii->ki", M)))  # to a unit diagonal
        return np.asarray(-np.linalg.eigvalsh(M * scale[:, :, None] * scale[:, None, :])[:, 0])

    def softness(t: Array, y: Array) -> Array:
        elastic = np.array([np.subtract(*spin.matrices(i, state)) for state in y])
        Kg = geometric_stiffness(model, model, i, t, y, loading(t, y))
        return np.asarray(-np.linalg.eigvalsh(elastic + Kg)[:, 0])

    t, values = run.scan(negative_mass, run.look.stiffening)
    bad = ~(-values > INDEFINITE.limit)
    if bad.any():
        yield from _of_mass(run, i, t[bad], -values[bad])
    if run.solution.counters.steps:
        return
    t, values = run.scan(softness, run.look.stiffening)
    for k in np.flatnonzero(-values <= BUCKLING.limit):
        when, row = float(t[k]), np.searchsorted(run.solution.t, t[k])
        if not joints_hold(model, when, run.solution.y[row]):
            text = buckling_text(name, when)
            yield BUCKLING.finding(text, body=name, t=when, value=-float(values[k]))
            return


def _of_mass(run: FinishedRun, i: int, t: Array, lowest: Array) -> Iterator[Finding]:
    """Yield the first time of t (k,) at which the mass of a body that is not positive counts.

    Joints may hold the body in the directions that have lost their mass, such as those of a
    clamped root: no motion of the mechanism is without inertia then. What remains is a body that
    has turned too far in itself, if it has.
    """
    model, name = run.model, run.built.body_names[i]
    some = np.linspace(0, t.size - 1, min(t.size, MOST_FREE)).astype(int)
    some = distinct(some, np.argmin(lowest))
    t, lowest = t[some], lowest[some]
    rows = np.searchsorted(run.solution.t, t)
    free = np.array(
        [_free_mass(model, when, run.solution.y[k]) for when, k in zip(t, rows, strict=True)]
    )
    turned = np.zeros(t.size)
    a = int(model.pos_start[i]) + 7
    q = run.solution.y[rows][:, a : a + int(model.n_mode[i])]
    for interface in run.packages[name].interfaces:
        turned = np.maximum(turned, np.linalg.norm(q @ interface.psi_B.T, axis=1))
    lost = ~(free > INDEFINITE.limit)
    counts = np.flatnonzero(lost | (turned > ROTATION.limit))
    if not counts.size:
        return
    k = counts[np.argmax(lost[counts])]  # the first, where a motion of the mechanism has none
    whose = "" if lost[k] else " alone"
    text = (
        f"{name}: at t = {t[k]:.4g} s the mass matrix of the body{whose} is not positive: "
        "it has moved too far from its frame for second-order displacements: "
        f"{run.better_frame(name)}model the part as several bodies with fixed joints "
        "between them (a beam: more segments)"
    )
    finding = INDEFINITE.finding(text, body=name, t=float(t[k]), value=float(lowest[k]))
    yield finding if lost[k] else finding._replace(level="warning")


def _free_mass(model: Model, t: float, y: Array) -> float:
    """Return the least eigenvalue of the mass of free motions, scaled to a unit diagonal."""
    equations = assemble(model, t, y)
    Z = free_motions(equations, model.inertia_scale).Z
    M = Z.T @ equations.M @ Z
    scale = 1.0 / np.sqrt(np.abs(np.diag(M)))
    return float(np.linalg.eigvalsh(M * scale[:, None] * scale)[0]) if M.size else 1.0


def _of_linear(
    run: FinishedRun, tables: Model, i: int, loading: Loading, spin: SpinMonitor
) -> Iterator[Finding]:
    """Yield the largest geometric stiffness of a linear body, if it is not small."""
    model, name = run.model, run.built.body_names[i]
    values, vectors = np.linalg.eigh(modal_matrix(model, model.K_qq, i))
    if values[0] <= FREE_MODE * values[-1]:
        return
    scale = vectors / np.sqrt(values)

    def share(t: Array, y: Array) -> Array:
        Kg = scale.T @ geometric_stiffness(model, tables, i, t, y, loading(t, y)) @ scale
        sizes = np.zeros(t.size)
        known = np.isfinite(Kg).all(axis=(1, 2))
        sizes[known] = np.abs(np.linalg.eigvalsh(Kg[known])).max(axis=1)
        return sizes

    t, shares = run.scan(share, run.look.stiffening)
    largest, when = float(shares.max()), float(t[np.argmax(shares)])
    if largest > MATTERS.limit:
        text = (
            f"{name}: at t = {when:.4g} s the geometric stiffness of the loads is "
            f"{largest:.2g} of the elastic one (a linear body neglects it: expected below "
            f"{MATTERS.limit:g}): solver.geometric_stiffening = true includes it"
        )
        yield MATTERS.finding(text, body=name, t=when, value=largest)
        return
    j = int(model.vel_start[i]) + 3
    w = run.solution.y[:, model.n_pos + j :][:, :3]
    k = int(np.argmax((w * w).sum(axis=1)))
    part = tilting(spin, tables, i, run.solution.y[k])
    if part > TILTING.limit:
        when = float(run.solution.t[k])
        yield TILTING.finding(f"{name}: {tilting_text(part)}", body=name, t=when, value=part)


def tilting(spin: SpinMonitor, tables: Model, i: int, y: Array) -> float:
    """Return the stiffness against whirling that linear body i lacks in state y (n,), relative.

    It neglects part of the rotary inertia of sections that tilt: rotary inertia times spin^2 over
    stiffness. Of the directions in which the spin takes a quarter of the stiffness of the frame and
    more, so 0 far below the first critical speed. A blade gets its stiffness by the spin there
    (`stiffening-matters`).

    Parameters
    ----------
    spin : monitor of the mechanism
    tables : model of the mechanism whose body i is of second order
    i : number of the body
    y : state (n,), as in dynamics/model/model.py
    """
    K, lost = spin.matrices(i, y)
    values, vectors = np.linalg.eigh(K)
    scale = vectors / np.sqrt(values)
    taken, V = np.linalg.eigh(scale.T @ lost @ scale)
    V = scale @ V[:, taken > WHIRLS]
    none = np.zeros((1, 3))
    Kg = stiffening_matrices(tables, i, spin.spin(i, y)[None], none, none, np.zeros((1, len(K))))[0]
    return float(np.diag(V.T @ Kg @ V).max(initial=0.0))


def tilting_text(part: float) -> str:
    """Return what `tilting` means for a shaft."""
    return (
        "sections of a linear body lack part of their rotary inertia as they tilt: at this spin "
        f"{part:.2g} of the stiffness (expected below {TILTING.limit:g}). Whirl frequencies are "
        f"wrong by up to {0.5 * part:.1g} of their value, and the response near a critical speed "
        "by several times that. solver.geometric_stiffening = true includes it"
    )
