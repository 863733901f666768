"""The moving bodies of a run for the view of the page: see solver/results/view.py."""

from typing import Any

import numpy as np

from ...math.arrays import Array, IntArray
from ...results import BodyGeometry, RunResult
from ...results.view import BodyView, Link, Sites
from ..story import Story
from .blob import Blob
from .frames import frame_rows, largest_displacement, largest_energy, one_sign
from .glyphs import WIDTH, foot, glyph

TRIANGLES = 60_000  # of a body; of more, every n-th is shown
STRENGTHS = ("Xt", "Xc", "Yt", "Yc", "Zt", "Zc", "S23", "S13", "S12", "F12_star")


def scene(blob: Blob, story: Story, share: int) -> dict[str, Any] | None:
    """Add the bodies and joints of a run; None if the result is older than views.

    share : numbers that its animation may take
    """
    result = story.result
    if not result.bodies or any(body.view is None for body in result.bodies):
        return None
    t = np.asarray(result.t)
    width = sum(7 + len(body.view.shapes_B) for body in result.bodies if body.view is not None)
    rows = frame_rows(t, _peaks(story), width, share)
    points = np.asarray(result.node_positions_G[rows])
    usable = points.reshape(-1, 3)[np.isfinite(points).all(axis=2).ravel()]
    low, high = usable.min(axis=0), usable.max(axis=0)
    origin, size = 0.5 * (low + high), float(np.linalg.norm(high - low)) or 1.0
    own = list(result.links)
    bodies = [
        _body(blob, result, i, body, body.view, rows, origin, own, size)
        | {"exposure": _largest_exposure(story, body.name)}
        for i, body in enumerate(result.bodies)
        if body.view is not None
    ]
    return {
        "t": blob.add(t[rows], "<f8"),
        "origin": origin,
        "size": size,
        "extent": high - low,
        "bodies": bodies + _ground(blob, own, origin, size, len(rows)),
        "joints": _pairs(own, result.bodies),
    }


def _peaks(story: Story) -> list[float]:
    """Times that the page jumps to: peaks of signals, of plies, and of findings."""
    summary = story.summary
    found = [s.get(key) for s in summary.get("signals", {}).values() for key in ("t_min", "t_max")]
    for body in summary.get("strength", {}).values():
        found += [body.get("time"), *(ply.get("time") for ply in body.get("plies", [])[:5])]
    found += [finding.get("t") for finding in summary.get("warnings", [])]
    return [float(value) for value in found if value is not None]


def _largest_exposure(story: Story, body: str) -> float:
    """Largest exposure 1/R of a body over the run, at most 1; 0 without strengths."""
    ratio = story.summary.get("strength", {}).get(body, {}).get("ratio")
    return min(1.0, 1.0 / ratio) if ratio else 0.0


def _body(
    blob: Blob,
    result: RunResult,
    number: int,
    body: BodyGeometry,
    view: BodyView,
    rows: IntArray,
    origin: Array,
    links: list[Link],
    size: float,
) -> dict[str, Any]:
    m, first = len(view.shapes_B), view.first_position
    q = np.asarray(result.q[:, first + 7 : first + 7 + m])
    motion = np.array(result.q[rows, first : first + 7])
    motion[:, :3] -= origin
    motion[:, 3:] = one_sign(motion[:, 3:])
    surface, nodes, shapes = view.surface, [body.nodes_B], [np.moveaxis(view.shapes_B, 0, 1)]
    count = len(body.nodes_B)
    node, offset = [surface.node], [surface.offset_B]
    every = max(1, -(-len(surface.triangles) // TRIANGLES))
    triangles, edges = [surface.triangles[::every]], [surface.edges[::every]]
    site, kind = [surface.site[::every]], [np.zeros(len(triangles[0]), dtype=np.int64)]
    for link in links:
        for side in link.sides:
            if side.body != number:
                continue
            points, faces = glyph(link.free, WIDTH * size)
            triangles.append(faces + sum(len(part) for part in node))
            node.append(np.full(len(points), count))
            offset.append(points @ side.A_BM.T)
            nodes.append(side.position_B[None])
            shapes.append(np.concatenate([side.phi_B, side.psi_B]).T[None])
            edges.append(np.zeros(len(faces), dtype=np.int64))
            site.append(np.full(faces.shape, -1))
            kind.append(np.ones(len(faces), dtype=np.int64))
            count += 1
    q_rows = q[rows]
    return {
        "name": body.name,
        "modes": m,
        "labels": view.labels,
        "motion": blob.add(motion),
        "q": blob.add(q_rows),
        "nodes": blob.add(np.concatenate(nodes)),
        "shapes": blob.add(np.concatenate(shapes)),  # (n, m, 6)
        "node": blob.add(np.concatenate(node), "<u4"),
        "offset": blob.add(np.concatenate(offset)),
        "triangles": blob.add(np.concatenate(triangles), "<u4"),
        "edges": blob.add(np.concatenate(edges), "|u1"),
        "site": blob.add(np.concatenate(site) + 1, "<u4"),  # 0: none
        "kind": blob.add(np.concatenate(kind), "|u1"),  # 1: joint
        "left_out": every,
        "displacement": largest_displacement(view, q),
        "energy": largest_energy(view, q),
        "sites": None if view.sites is None or not m else _sites(blob, view.sites),
    }


def _sites(blob: Blob, sites: Sites) -> dict[str, Any]:
    """Resultants padded to eight, so that beams and shells are evaluated alike."""
    j = sites.resultants_E.shape[1]
    R = np.zeros((len(sites.kind), sites.resultants_E.shape[2], 8))
    R[:, :, :j] = np.moveaxis(sites.resultants_E, 1, 2)
    C = np.zeros((len(sites.compliance), 8, 8))
    C[:, :j, :j] = sites.compliance
    S = np.zeros((len(sites.stress_M), 6, 8))
    S[:, :, :j] = sites.stress_M
    order = np.argsort(sites.point_kind, kind="stable")
    starts = np.searchsorted(sites.point_kind[order], np.arange(len(C) + 1))
    return {
        "place": blob.add(sites.place_B),
        "R": blob.add(R),  # (s, m, 8)
        "kind": blob.add(sites.kind, "<u4"),
        "C": blob.add(C),
        "S": blob.add(S[order]),  # (i, 6, 8), points of one kind together
        "starts": starts,
        "ply": blob.add(sites.point_ply[order], "<u4"),
        "strength": blob.add(np.array([_strength(ply) for ply in sites.plies]).reshape(-1, 12)),
        "area": j == 8,
    }


def _strength(ply: dict[str, Any]) -> list[float]:
    """Twelve numbers: kind (1 ply, 2 metal, 0 none), yield stress, then STRENGTHS."""
    found = ply.get("strength")
    if not found:
        return [0.0] * 12
    if "yield_stress" in found:
        return [2.0, found["yield_stress"], *[1.0] * 10]
    return [1.0, 1.0, *(found[name] for name in STRENGTHS)]


def _ground(
    blob: Blob, links: list[Link], origin: Array, size: float, count: int
) -> list[dict[str, Any]]:
    """Return a body without motion at `count` times with the sides of joints on the ground."""
    places = [side for link in links for side in link.sides if side.body < 0]
    if not places:
        return []
    shape, faces = foot(WIDTH * size)
    p, f = len(shape), len(faces)
    still = np.tile(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), (count, 1))
    triangles = np.concatenate([faces + p * k for k in range(len(places))])
    return [
        {
            "name": "ground",
            "modes": 0,
            "labels": (),
            "motion": blob.add(still),
            "q": blob.add(np.zeros((count, 0))),
            "nodes": blob.add(np.array([side.position_B - origin for side in places])),
            "shapes": blob.add(np.zeros((len(places), 0, 6))),
            "node": blob.add(np.repeat(np.arange(len(places)), p), "<u4"),
            "offset": blob.add(np.concatenate([shape @ side.A_BM.T for side in places])),
            "triangles": blob.add(triangles, "<u4"),
            "edges": blob.add(np.zeros(f * len(places)), "|u1"),
            "site": blob.add(np.zeros((f * len(places), 3)), "<u4"),
            "kind": blob.add(np.ones(f * len(places)), "|u1"),
            "left_out": 1,
            "displacement": 0.0,
            "energy": 0.0,
            "exposure": 0.0,
            "sites": None,
        }
    ]


def _pairs(links: list[Link], bodies: tuple[BodyGeometry, ...]) -> list[dict[str, Any]]:
    """Both sides of each joint: body and row of its nodes; of the ground a position."""
    counts = {number: len(body.nodes_B) for number, body in enumerate(bodies)}
    found = []
    for link in links:
        sides = []
        for side in link.sides:
            sides.append({"body": side.body, "node": counts.get(side.body, -1)})
            if side.body < 0:
                sides[-1]["at"] = side.position_B.tolist()
            elif side.body in counts:
                counts[side.body] += 1
        found.append({"name": link.name, "kind": link.kind, "sides": sides})
    return found
