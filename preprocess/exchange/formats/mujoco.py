"""Modal package to MuJoCo: a chain of rigid segments on virtual joints with springs (MJCF).

The body is cut across the line from the interface that carries its frame to the farthest one. At
each cut there are three hinges, about the principal axes of the stiffness with which the moments of
the body's modes turn the chain as the modes do. The stiffnesses are then changed as little as it
takes to give the chain the lowest frequencies of the body, clamped at its frame, and the angles by
which moments turn its interfaces, as far as attachment modes have them.
"""

from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree as ET

import numpy as np
from scipy.linalg import block_diag, eigh, eigvalsh, solve_continuous_lyapunov
from scipy.spatial.transform import Rotation

from ....solver.errors import InputError, printable
from ....solver.math.arrays import Array, IntArray
from ....solver.package import ModalPackage
from ....solver.package.body.selection import interface_load
from ....solver.package.common.files import write_text
from ....solver.package.specification import DIRECTIONS

SUFFIX = ".xml"
FEWEST, MOST, UNEVEN = 6, 40, 24  # cuts: least, most between nodes of a beam; of other meshes
SAME = 1e-6  # of the length: nodes of one cross-section
MATCHED, ENOUGH = 3, 0.01  # frequencies, and their largest relative error
PAIRED = 1e-3  # relative difference of the frequencies of a pair
PASSES, LARGEST = 20, 0.5  # of the fit; change of a logarithm of a frequency in one
FARTHEST = 5.0  # change of a logarithm of a stiffness in one
SOFT = 1e-3  # of the median stiffness, for cuts that no mode bends
STIFF = 1e-4  # of the largest angles: there is no hinge about which modes turn a cut by less
FLAT = 1e-7  # of the moments of inertia: MuJoCo refuses those of a disc by their last digit
STEPS = 12.0  # of the time step in a period of the fastest motion


class Chain(NamedTuple):
    """Segments and cuts; the first segment stands on the frame."""

    of_node: IntArray  # (n,) segment
    points: Array  # (N, 3) cuts [m]
    axes: Array  # (3, 3) rows: along the line, and two across it, whatever the sections
    mass: Array  # (N + 1,) of segments [kg]
    centre: Array  # (N + 1, 3) [m]
    inertia: Array  # (N + 1, 3, 3) about the centre [kg m2]


def write(package: ModalPackage, out: Path, source: Path) -> str:
    """Write the chain; returns its frequencies beside those of the body.

    Parameters
    ----------
    package, out : see contract.py
    source : is named in messages

    Raises
    ------
    InputError
        A frame that is not clamped; a body that is no chain: too few nodes along it, or
        frequencies that no stiffnesses of hinges have.
    """
    chain = chain_of(package)
    aim = np.sqrt(eigvalsh(package.stiffness, package.mass))
    aim = aim[aim < aim[:MATCHED][-1] * (1.0 + PAIRED)]
    k, axes, M = _stiffnesses(package, chain, aim)
    held = k.ravel() > 0.0
    w = np.sqrt(eigvalsh(np.diag(k.ravel()[held]), M[np.ix_(held, held)]))
    error = float(np.abs(w[: aim.size] / aim - 1.0).max())
    hertz, theirs = (", ".join(f"{f / (2.0 * np.pi):.5g}" for f in each[:3]) for each in (w, aim))
    if not error < ENOUGH:
        raise InputError(
            f"{source}: a chain of virtual joints has {hertz} Hz, the body {theirs} Hz: it does "
            "not move as a chain; expected a slender body, clamped at one end"
        )
    ratio = package.damping[0, 0] / (2.0 * package.frequencies[0] * package.mass[0, 0])
    text = _mjcf(package, chain, k, axes, 2.0 * float(ratio) / aim[0], 2.0 * np.pi / w[-1] / STEPS)
    write_text(out, text)
    return f"{np.count_nonzero(held)} hinges: {hertz} Hz; the body, clamped: {theirs} Hz"


def chain_of(package: ModalPackage) -> Chain:
    """Cut the body. Raises InputError for one that cannot be cut."""
    if package.reference_condition != "clamped":
        raise InputError(
            f"reference_condition = {package.reference_condition!r}: expected a body whose frame "
            "is clamped at an interface, the end at which the chain stands"
        )
    places = np.array([i.position_B for i in package.interfaces])
    still = [float(np.abs(np.vstack([i.phi_B, i.psi_B])).max()) for i in package.interfaces]
    root = places[int(np.argmin(still))]
    far = np.vstack([places, package.nodes_B]) if len(places) < 2 else places
    line = far[int(np.argmax(np.linalg.norm(far - root, axis=1)))] - root
    length = float(np.linalg.norm(line))
    e = line / length
    across = np.eye(3)[int(np.argmin(np.abs(e)))]
    y = np.cross(e, across) / np.linalg.norm(np.cross(e, across))
    axes = np.array([e, y, np.cross(e, y)])
    s = (package.nodes_B - root) @ e
    stations = np.sort(s)
    stations = stations[np.append(True, np.diff(stations) > SAME * length)]
    if stations.size - 1 < FEWEST:
        raise InputError(
            f"{stations.size} nodes along the body; expected {FEWEST + 1} at least, for a chain"
        )
    if stations.size - 1 <= MOST:
        cuts = 0.5 * (stations[:-1] + stations[1:])
    else:
        cuts = stations[0] + np.ptp(stations) * (np.arange(UNEVEN) + 0.5) / UNEVEN
    of_node = np.searchsorted(cuts, s)
    count = cuts.size + 1
    mass = np.bincount(of_node, package.node_mass, count).astype(float)
    centre = np.zeros((count, 3))
    np.add.at(centre, of_node, package.node_mass[:, None] * package.nodes_B)
    centre /= mass[:, None]
    inertia = np.zeros((count, 3, 3))
    arm = _skew(package.nodes_B - centre[of_node])
    own = package.node_mass[:, None, None] * np.einsum("nab,ncb->nac", arm, arm)
    np.add.at(inertia, of_node, own + package.node_inertia_B)
    beside = (centre - root) @ axes[1:].T  # of the line of centres
    at = np.column_stack([np.interp(cuts, (centre - root) @ e, beside[:, k]) for k in (0, 1)])
    return Chain(of_node, root + cuts[:, None] * e + at @ axes[1:], axes, mass, centre, inertia)


def jacobians(chain: Chain) -> Array:
    """Return motions of the segments' centres by the angles, (N + 1, 6, 3 N)."""
    count = len(chain.points)
    J = np.zeros((count + 1, 6, count, 3))
    for i, point in enumerate(chain.points):
        J[i + 1 :, 3:, i] = chain.axes.T
        arm = (chain.centre[i + 1 :] - point)[:, None]
        J[i + 1 :, :3, i] = np.cross(chain.axes, arm).swapaxes(1, 2)
    return J.reshape(count + 1, 6, 3 * count)


def _skew(a: Array) -> Array:
    """Return the matrices of cross products with vectors (n, 3)."""
    return np.asarray(np.cross(a[:, None], np.eye(3)).swapaxes(1, 2))


def _stiffnesses(package: ModalPackage, chain: Chain, aim: Array) -> tuple[Array, Array, Array]:
    """Return stiffness (N, 3) [N m / rad] and axes (N, 3, 3) of the hinges, and the mass matrix.

    A stiffness of 0 stands for no hinge. The mass matrix (3 N, 3 N) is that of all.
    """
    count = len(chain.points)
    J = jacobians(chain)
    M = np.einsum("sai,s,saj->ij", J[:, :3], chain.mass, J[:, :3])
    M += np.einsum("sai,sab,sbj->ij", J[:, 3:], chain.inertia, J[:, 3:])
    squares, q = eigh(package.stiffness, package.mass)
    # Angles that move the nodes as a mode does, by least squares with the masses.
    root = np.sqrt(package.node_mass)[:, None, None]
    arm = package.nodes_B - chain.centre[chain.of_node]
    moves = J[chain.of_node, :3] - np.einsum("nab,nbj->naj", _skew(arm), J[chain.of_node, 3:])
    rows = [(root * moves).reshape(-1, M.shape[0])]
    shapes = [root * package.shapes_B[:, :, :3].transpose(1, 2, 0)]
    if package.shapes_B.shape[2] == 6:
        turn = np.linalg.cholesky(package.node_inertia_B + 1e-30 * np.eye(3)).swapaxes(1, 2)
        rows.append((turn @ J[chain.of_node, 3:]).reshape(-1, M.shape[0]))
        shapes.append(turn @ package.shapes_B[:, :, 3:].transpose(1, 2, 0))
    wanted = np.vstack([shape.reshape(-1, q.shape[0]) for shape in shapes]) @ q
    angles = np.linalg.lstsq(np.vstack(rows), wanted, rcond=1e-12)[0]
    loads, moments, turning = _attachments(package, chain)
    answers = q.T @ loads / squares[:, None]
    # The strain energy of each is that of the first mode under its inertia forces.
    weights = 1.0 / np.sqrt(squares[0] * np.sum(squares[:, None] * answers**2, axis=0))
    k, turns = _principal(
        np.hstack([angles, angles @ answers * weights]).reshape(count, 3, -1),
        np.hstack([M @ angles, moments * weights]).reshape(count, 3, -1),
        np.append(squares, np.ones(len(weights))),
    )
    B = block_diag(*turns)
    M, turned = B.T @ M @ B, k.ravel() > 0.0
    inner = M[np.ix_(turned, turned)]
    moments = (B.T @ moments[:, turning])[turned]
    angle = np.sum(squares[:, None] * answers**2, axis=0)[turning]
    for kept in (moments, moments[:, :0]):  # a plate twists otherwise than a chain
        fitted = _fitted(k.ravel()[turned], inner, aim, kept, angle[: kept.shape[1]])
        w = np.sqrt(eigvalsh(np.diag(fitted), inner)[: aim.size])
        if np.abs(w / aim - 1.0).max() < ENOUGH:
            break
    k[k > 0.0] = fitted
    return k, turns.swapaxes(1, 2) @ chain.axes, M


def _fitted(k: Array, M: Array, aim: Array, moments: Array, angle: Array) -> Array:
    """Return stiffnesses (n,) that give the chain its frequencies, and its end the angles.

    By the least change, which is that of the energies.

    Parameters
    ----------
    k : of the hinges (n,) [N m / rad]
    M : mass matrix (n, n)
    aim : frequencies [rad/s]
    moments : (n, p) in the hinges, by unit moments at interfaces
    angle : (p,) about these, of the interfaces [rad / (N m)]
    """
    for _ in range(PASSES):
        found, v = eigh(np.diag(k), M, subset_by_index=[0, aim.size - 1])
        # Pairs as one: each mode of a pair has any direction.
        pairs = np.abs(found / found[:, None] - 1.0) < PAIRED
        mean = pairs / pairs.sum(axis=0)
        parts = moments**2 / k[:, None]
        there = parts.sum(axis=0)
        shares = np.hstack([k[:, None] * v**2 / found @ mean, parts / there])
        change = np.clip(np.log(aim**2 / found), -LARGEST, LARGEST) @ mean
        change = np.append(change, np.log(there / angle))
        least = np.linalg.pinv(shares.T, rcond=1e-6) @ change
        k = k * np.exp(np.clip(least, -FARTHEST, FARTHEST))
    return k


def _attachments(package: ModalPackage, chain: Chain) -> tuple[Array, Array, list[int]]:
    """Return the loads of attachment modes (m, p), their moments (3 N, p) at the cuts, and which
    of them are moments.

    The body answers these loads as if it had all of its modes. Moments by inertia forces of its
    modes are true for its lowest vibrations only.
    """
    places = {each.name: each.position_B for each in package.interfaces}
    loads, moments = [np.zeros((len(package.stiffness), 0))], [np.zeros((chain.points.size, 0))]
    turning: list[int] = []
    for label in package.mode_labels:
        kind, at, way = (*label.split(), "", "", "")[:3]
        if kind != "attachment" or at not in places:
            continue
        row, arms = DIRECTIONS.index(way), places[at] - chain.points  # type: ignore[arg-type]
        unit = np.eye(3)[row % 3]
        moment = np.cross(arms, unit) if row < 3 else np.tile(unit, (len(arms), 1))
        moment[arms @ chain.axes[0] < 0.0] = 0.0
        turning += [len(loads) - 1] if row >= 3 else []
        loads.append(interface_load(package, at, way)[:, None])
        moments.append((moment @ chain.axes.T).reshape(-1, 1))
    return np.hstack(loads), np.hstack(moments), turning


def _principal(angles: Array, loads: Array, squares: Array) -> tuple[Array, Array]:
    """Return principal stiffnesses (N, 3) of the cuts and their directions, columns of (N, 3, 3).

    At each cut the symmetric matrix K that turns the angles of the modes into their moments, by
    least squares: a section may have its axes anywhere, and bend as it twists. The lowest modes
    have most weight. Directions about which no mode turns the cuts have a stiffness of 0.

    Parameters
    ----------
    angles : (N, 3, m) of the cuts in the modes, and under the loads of `_attachments`
    loads : (N, 3, m) moments of their inertia forces over `squares`, and of these loads
    squares : (m,) of the frequencies; 1 for these loads
    """
    turned = angles @ angles.swapaxes(1, 2)
    S = (angles / squares**2) @ angles.swapaxes(1, 2)
    R = (loads / squares) @ angles.swapaxes(1, 2)
    # What the modes of a cut leave open is as it is on average.
    turned, S, R = (each + SOFT * each.mean(axis=0) for each in (turned, S, R))
    k, turns = np.zeros((len(S), 3)), np.zeros((len(S), 3, 3))
    least = STIFF**2 * float(np.linalg.eigvalsh(turned).max())
    for i in range(len(S)):
        sizes, basis = np.linalg.eigh(turned[i])
        held = basis[:, sizes > least]
        both = held.T @ (R[i] + R[i].T) @ held
        inside, own = np.linalg.eigh(solve_continuous_lyapunov(held.T @ S[i] @ held, both))
        turns[i] = basis
        turns[i][:, sizes > least] = held @ own
        k[i, sizes > least] = inside
        # torsion first, then bending by its stiffness
        torsion = int(np.argmax(np.abs(turns[i][0])))
        order = [torsion, *(j for j in np.argsort(k[i], kind="stable") if j != torsion)]
        k[i], turns[i] = k[i][order], turns[i][:, order]
    for column in k.T:
        found = column > 0.0
        median = float(np.median(column[found])) if found.any() else 0.0
        column[:] = np.maximum(column, SOFT * median)
    return k, turns


def _mjcf(
    package: ModalPackage, chain: Chain, k: Array, axes: Array, damping: float, step: float
) -> str:
    """Return the text of the model: the chain on the world, sites at the interfaces.

    damping : of a hinge over its stiffness [s]
    step : time step [s]
    """
    name = printable(package.body)
    root = ET.Element("mujoco", model=name)
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    ET.SubElement(root, "option", timestep=f"{step:.3g}", integrator="implicit")
    parent, origin = ET.SubElement(root, "worldbody"), np.zeros(3)
    ends = [*chain.points, chain.centre[-1]]
    for s, mass in enumerate(chain.mass):
        point = chain.points[s - 1] if s else np.zeros(3)
        own = {"name": f"{name}.{s}" if s else name, "pos": _words(point - origin)}
        parent, origin = ET.SubElement(parent, "body", own), point
        J = chain.inertia[s] + FLAT * np.trace(chain.inertia[s]) * np.eye(3)
        full = J[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        ET.SubElement(
            parent,
            "inertial",
            pos=_words(chain.centre[s] - origin),
            mass=f"{mass:.12g}",
            fullinertia=_words(full),
        )
        for axis in range(3) if s else ():
            stiffness = k[s - 1, axis]
            if not stiffness > 0.0:
                continue
            ET.SubElement(
                parent,
                "joint",
                name=f"{name}.{s}.{'xyz'[axis]}",
                axis=_words(axes[s - 1, axis]),
                stiffness=f"{stiffness:.12g}",
                damping=f"{damping * stiffness:.6g}",
            )
        size = f"{0.01 * np.linalg.norm(ends[-1] - ends[0]):.3g}"
        line = _words(np.concatenate([point - origin, ends[s] - origin]))
        shown = {"type": "capsule", "fromto": line, "size": size}
        ET.SubElement(parent, "geom", shown, mass="0", contype="0", conaffinity="0")
        for interface in package.interfaces:
            e, x_B = chain.axes[0], interface.position_B
            if int(np.searchsorted(chain.points @ e, x_B @ e)) == s:
                x, y, z, w = Rotation.from_matrix(interface.A_BI).as_quat()
                place = {"pos": _words(x_B - origin), "quat": _words(np.array([w, x, y, z]))}
                ET.SubElement(parent, "site", place, name=printable(interface.name))
    ET.indent(root)
    return str(ET.tostring(root, encoding="unicode")) + "\n"


def _words(values: Array) -> str:
    return " ".join(f"{value:.12g}" for value in values)
