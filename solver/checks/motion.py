"""Elastic rotations: how far interfaces turn relative to the frame of their body."""

from collections.abc import Iterator
from math import ceil, tau

import numpy as np

from ..dynamics.analysis.recovery import stiffened
from ..results.codes import ROTATION
from ..results.finding import Finding
from .finished import FinishedRun

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
        text = _text(whole, name, rotation, count, second_order=stiffened(run.model, i))
        yield ROTATION.finding(text, body=whole, value=rotation)


def _text(whole: str, name: str, rotation: float, count: int, *, second_order: bool) -> str:
    """Return the message; `count` is the number of segments of a beam, 0 of another body.

    The rotation relative to the chord of a segment is about inverse to their number; that of the
    segment in which a beam bends most falls a little more slowly. A rotation above a full turn, of
    displacements without meaning, says nothing of the number.
    """
    part = f" of segment {name}" if count > 1 else ""
    turn = f"{whole}: an interface{part} turns by {rotation:.2f} rad relative to the body frame "
    limit = f"below {ROTATION.limit:g} rad"
    if rotation > tau:
        limit += "; this result is invalid"
    split = "split the body"
    if count:
        now = f" ({count} now)" if count > 1 else ""
        number = ceil((UNEVEN if count > 1 else 1.0) * count * rotation / ROTATION.limit)
        wanted = f" = {number}" if rotation <= tau else ""
        split = f"divide the beam by segments{wanted}{now}"
    if second_order:
        frame = "" if count > 1 else "use a chord or mean-axis frame, or "
        accuracy = "expect an error of about 2 % at 0.25 rad"
        return f"{turn}(second-order body: {limit}; {accuracy}): {frame}{split}"
    if count:
        split += ", with solver.geometric_stiffening = true"
    return f"{turn}(linear bodies: {limit}): {split}, or stiffen it"
