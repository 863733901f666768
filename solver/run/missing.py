"""What the modes of a beam miss of the static deformation under the loads of a run.

The equilibrium of the part beyond a section gives the resultants F there (signals/cut.py). Those of
the modes are R q. Their difference is the static response of all modes that the body lacks:

    Delta F = F - R q_s,                      q_s = q + K^-1 (D q_d + M q_dd),
    U_missing = 1/2 int Delta F' C Delta F dx

with the compliance C of the sections. Neither has the inertia of the vibrations, so that the
difference does not ring with them: F is that of the loads and of the moving frame, and of what
holds the frame without work on the modes. It is orthogonal to the modes: the static deformation
under the same loads has the strain energy U_missing + 1/2 q_s' K q_s.
"""

from collections.abc import Callable, Iterator

import numpy as np

from ..checks.finished import ROUNDING, FinishedRun, Missing
from ..dynamics.analysis.recovery import body_frames, stiffened
from ..dynamics.evaluation import series
from ..dynamics.model.model import Model
from ..errors import InputError
from ..math.arrays import Array
from ..math.rotations import skew, vectors_to_matrices
from ..package import ModalPackage
from ..signals.cut import NEAR, Cut
from ..signals.recording import Recording

WINDOWS, WIDTH = 6, 9  # how many are looked at, and outputs in each
OVERSHOOT = 1.5  # mean strain energy of a vibration that a sudden load starts, of the static one
ASKEW = 0.3  # energy of Delta F along the modes, of its own: the data of the package do not agree
EXTENSION = 0  # row of the resultants


def missing(run: FinishedRun, body: int, recording: Recording, windows: int) -> Missing | None:
    """Return what the modes of a body miss; None if it is no straight beam with its sections."""
    name = run.built.body_names[body]
    package, model = run.packages[name], run.model
    try:
        beam = Cut(name, run.built, body, package, 0.0)
    except InputError:
        return None
    j, m = model.n_pos + int(model.vel_start[body]) + 6, package.n_mode
    q = recording.modes(body)
    K, D = (_square(model, body, each, m) for each in (model.K_qq, model.D_qq))
    rest = D @ recording.y[:, j : j + m].T + package.mass @ recording.rates[:, j : j + m].T
    static = q + np.linalg.solve(K, rest).T
    F, loads_B, size = _resultants(beam, recording, package)
    C, R = _elements(package, beam.along)
    dx = np.diff(beam.along)
    gap = F - np.einsum("eiam,km->keia", R, static)

    def energy(resultants: Array) -> Array:
        return 0.5 * _products(resultants, resultants @ C, dx)

    parts, slow = _slow(gap, energy, windows)
    lost = float(parts.sum())
    modes = np.moveaxis(R, 3, 0) @ C
    along = np.array([_products(gap, mode, dx).sum(axis=1) for mode in modes]).T
    askew = 0.5 * float(np.mean(np.sum(along * np.linalg.solve(K, along.T).T, axis=1)))
    rounding = float(energy(np.broadcast_to(size, (1, *gap.shape[1:]))).sum())
    if lost <= ROUNDING**2 * rounding or askew > ASKEW * energy(gap).sum(axis=1).mean():
        return None
    if not any("axial" in label or label.endswith(" x") for label in package.mode_labels):
        parts[EXTENSION] = 0.0  # left out on purpose: a slender beam hardly stretches
    half = float(_slow(static, lambda v: 0.5 * (v @ K) * v, windows)[0].sum())
    moved = 0.5 * float(np.mean(np.sum((q @ K) * q, axis=1)))
    whole = lost + max(moved / OVERSHOOT, min(half, moved))
    w = int(np.argmax(energy(slow).sum(axis=1)))
    rows = np.array([3, 4, 5] if parts[3:].sum() >= parts[EXTENSION] else [EXTENSION])
    most = np.abs(slow[w][:, :, rows])
    e, end, a = np.unravel_index(int(np.argmax(most)), most.shape)
    row = int(rows[a])
    total = float(_means(F, windows)[w, e, end, row])
    return Missing(
        share=float(parts.sum() / whole),
        t=float(_means(recording.t, windows)[w]),
        parts=parts / whole,
        row=row,
        x=float(beam.along[e + end]),
        carried=total - float(slow[w, e, end, row]),
        whole=total,
        loads_B={key: _means(each, windows)[w] for key, each in loads_B.items()},
    )


def missing_of(run: FinishedRun) -> Callable[[int], Missing | None]:
    """Return `missing` of a run, by number of the body."""
    recording, windows = look(run)
    return lambda body: missing(run, body, recording, windows)


def look(run: FinishedRun) -> tuple[Recording, int]:
    """Return the states that are looked at, in windows of neighbouring outputs, and their number.

    The mean of a window is the slow part of a load: static shapes of joints vibrate fast.
    """
    count = run.solution.t.size
    width = min(WIDTH, count)
    windows = max(1, min(WINDOWS, count // width))
    first = np.linspace(0, count - width, windows).astype(int)
    rows = (first[:, None] + np.arange(width)).ravel()
    return Recording(run.model, run.solution.t[rows], run.solution.y[rows]), windows


def _means(values: Array, windows: int) -> Array:
    """Return the means over windows, of values (k, ...)."""
    return np.asarray(values.reshape(windows, -1, *values.shape[1:]).mean(axis=1))


def _slow(values: Array, energy: Callable[[Array], Array], windows: int) -> tuple[Array, Array]:
    """Return the mean energies (n,) of the slow part of values (k, ...), and its values.

    Of what varies at random in a window of w values, 1/w of the energy is left in their mean.
    """
    means, w = _means(values, windows), len(values) // windows
    left, all_of = energy(means).mean(axis=0), energy(values).mean(axis=0)
    return np.maximum(w * left - all_of, 0.0) / (w - 1.0) if w > 1 else left, means


def _square(model: Model, body: int, flat: Array, m: int) -> Array:
    """Return the (m, m) matrix of a body from those of all."""
    a = int(model.square_start[body])
    return np.asarray(flat[a : a + m * m]).reshape(m, m)


def _elements(package: ModalPackage, along: Array) -> tuple[Array, Array]:
    """Return the compliance (e, 6, 6) of elements and the resultants (e, 2, 6, m) of the modes."""
    recovery = package.recovery
    assert recovery is not None  # of every `Cut`
    near = NEAR * along[-1]
    K = np.array([section.K for section in package.sections])
    K = 0.5 * (K[:-1] + K[1:]) if len(K) > 1 else np.repeat(K, len(along) - 1, axis=0)
    first = np.searchsorted(recovery.station_x, along[:-1] + near, side="right") - 1
    last = np.searchsorted(recovery.station_x, along[1:] - near)
    R = np.stack([recovery.resultants_E[first], recovery.resultants_E[last]], axis=1)
    return np.linalg.inv(K), R


def _resultants(
    beam: Cut, recording: Recording, package: ModalPackage
) -> tuple[Array, dict[str, Array], Array]:
    """Return the resultants (k, e, 2, 6) at both ends of each element, by equilibrium.

    Those of a linear body on its undeformed line, as in its equations. Also returns the loads
    (k, 6) at its interfaces, body axes, by name; and the size (6,) of what adds up to resultants.
    """
    model, along = beam.model, beam.along
    near, length = NEAR * along[-1], float(along[-1])
    r, A, q = body_frames(model, beam.body, recording.y)
    section = np.broadcast_to(beam.nodes, (len(q), *beam.nodes.shape))
    axes = np.broadcast_to(beam.A_BE, (*section.shape, 3))
    j = model.n_pos + int(model.vel_start[beam.body])
    rigid = recording.rates[:, j : j + 6 + q.shape[1]] * (np.arange(6 + q.shape[1]) < 6)
    place, f, h_d = beam.slice_loads(A, q, recording.y[:, j : j + 6 + q.shape[1]], rigid)
    bent = stiffened(model, beam.body)
    if bent:
        moved = np.einsum("sam,km->ksa", beam.motion_at(along), q)
        section = section + moved[:, :, :3]
        axes = (vectors_to_matrices(moved[:, :, 3:].reshape(-1, 3)) @ beam.A_BE).reshape(axes.shape)
    else:
        place = np.broadcast_to(beam.place_B, place.shape)
    # Force and moment about the origin of the body, summed from the far end.
    wrench = np.concatenate([f, np.cross(place, f) - h_d], axis=2)
    wrench = wrench.reshape(len(q), len(along) - 1, 2, 6).sum(axis=2)
    beyond = np.flip(np.cumsum(np.flip(wrench, 1), axis=1), 1)
    ends = np.stack([beyond, beyond - wrench], axis=2)
    weight = beam.mass.sum() * float(np.linalg.norm(model.gravity_G))
    force, moment = weight + float(np.abs(f).sum(axis=1).max(initial=0.0)), 0.0
    total, loads_B = wrench.sum(axis=1), dict[str, Array]()
    for marker, load in _loads(beam, recording):
        rest = np.asarray(model.marker_x[marker])
        load_B = np.einsum("kba,kcb->kca", A, load.reshape(-1, 2, 3))
        force += float(np.abs(load_B[:, 0]).max(initial=0.0))
        moment += float(np.abs(load_B[:, 1]).max(initial=0.0))
        for one in package.interfaces:
            if np.abs(one.position_B - rest).max() <= near:
                before = loads_B.get(one.name, np.zeros((len(q), 6)))
                loads_B[one.name] = before + load_B.reshape(-1, 6)
        at = np.broadcast_to(rest, r.shape)
        if bent:
            at = np.einsum("kba,kb->ka", A, recording.position(marker) - r)
        about = load_B[:, 1] + np.cross(at, load_B[:, 0])
        each = np.concatenate([load_B[:, 0], about], axis=1)
        _add(ends, beam, float(rest[0] - beam.nodes[0, 0]), each)
        total += each
    _hold(ends, beam, package, section, place, -total)
    turned = np.stack([axes[:, :-1], axes[:, 1:]], axis=2)
    arm = np.stack([section[:, :-1], section[:, 1:]], axis=2)
    M = ends[..., 3:] - np.cross(arm, ends[..., :3])
    F = [np.einsum("ksiba,ksib->ksia", turned, each) for each in (ends[..., :3], M)]
    size = np.array([force] * 3 + [moment + force * length] * 3)
    return np.concatenate(F, axis=3), loads_B, size


def _add(ends: Array, beam: Cut, x: float, wrench: Array) -> None:
    """Add a wrench (k, 6) about the origin, which acts at x, to the sections before it."""
    near = NEAR * beam.along[-1]
    ends[:, beam.along[:-1] + near < x, 0] += wrench[:, None]
    ends[:, beam.along[1:] - near < x, 1] += wrench[:, None]


def _hold(
    ends: Array, beam: Cut, package: ModalPackage, section: Array, place: Array, total: Array
) -> None:
    """Add what holds the frame: a total wrench (k, 6) that does no work on the modes.

    A clamped frame is held at its node, a chord at both of its ends, a mean axis by the inertia of
    a rigid motion.
    """
    size = np.abs(package.shapes_B).max(axis=(0, 1)) + 1e-300
    still = np.all(np.abs(package.shapes_B) <= NEAR * size, axis=0)  # (n, 6)
    if package.reference_condition == "mean-axis":
        x, m = beam.place_B, beam.mass
        H = np.array([np.hstack([np.eye(3), -skew(one)]) for one in x])  # motion of a slice
        turn = np.hstack([np.zeros((3, 3)), np.eye(3)])
        moment = np.array([skew(one) for one in x]) @ H
        rows = np.concatenate([m[:, None, None] * H, m[:, None, None] * moment], axis=1)
        rows[:, 3:] += beam.J_B @ turn
        a = np.linalg.solve(rows.sum(axis=0), total.T)
        wrench = np.einsum("pij,jk->kpi", rows, a).reshape(len(total), -1, 2, 6).sum(axis=2)
        beyond = np.flip(np.cumsum(np.flip(wrench, 1), axis=1), 1)
        ends += np.stack([beyond, beyond - wrench], axis=2)
        return
    held = np.flatnonzero(
        still.all(axis=1) if package.reference_condition == "clamped" else still[:, 1:3].all(axis=1)
    )
    if not held.size:  # another frame than its condition says: not orthogonal, not judged
        return
    i, j = int(held[0]), int(held[-1])
    second = np.zeros_like(total)
    if j > i:
        F, M, arm = total[:, :3], total[:, 3:], section[:, j] - section[:, i]
        M = M - np.cross(section[:, i], F)
        second[:, 1], second[:, 2] = M[:, 2] / arm[:, 0], -M[:, 1] / arm[:, 0]
        second[:, 3:] = np.cross(section[:, j], second[:, :3])
    _add(ends, beam, float(beam.along[j]), second)
    _add(ends, beam, float(beam.along[i]), total - second)


def _loads(beam: Cut, recording: Recording) -> Iterator[tuple[int, Array]]:
    """Yield the marker and the load (k, 6) of each joint, force and mass on a body, global."""
    model = beam.model
    markers = series.loaded_markers(model)
    for p in np.flatnonzero(np.asarray(model.marker_body)[markers] == beam.body).tolist():
        yield int(markers[p]), recording.loads([p])[:, 0]
    for marker, mass in beam.built.point_masses:
        if model.marker_body[marker] == beam.body:
            force = mass * (model.gravity_G - recording.acceleration(marker))
            yield marker, np.concatenate([force, np.zeros_like(force)], axis=1)


def _products(a: Array, b: Array, lengths: Array) -> Array:
    """Return int a b dx (..., 6) by component, of values (..., e, 2, 6) linear in each element."""
    middle = a.sum(axis=-2) * b.sum(axis=-2)  # four times that in the middle
    return np.asarray(((a * b).sum(axis=-2) + middle).swapaxes(-1, -2) @ (lengths / 6.0))
