"""Driven frames: frames whose motion is prescribed by joints to the ground.

A frame is driven if joints to the ground that do not depend on modes constrain all of its six
degrees of freedom, without redundancy: a blade on a hub of prescribed speed, a clamped beam.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..math.arrays import Array, IntArray

FREEDOMS = 6


class Stand(NamedTuple):
    """A joint or drive as seen from here: what it takes and where it holds on."""

    removes: tuple[str, ...] | None  # freedoms that its rows take, one each; None: others as well
    bodies: tuple[int, int]  # of its two markers; -1: ground
    rigid: bool  # its marker on the body does not depend on the modes
    x: Array  # (3,) of that marker
    A: Array  # (3, 3)


def driven_frames(joints: Sequence[Stand]) -> IntArray:
    """Return, by joint, the body whose frame it drives, alone or with others; -1: none."""
    out = np.full(len(joints), -1, dtype=np.int64)
    at_body: dict[int, list[int]] = {}
    for k, joint in enumerate(joints):
        if joint.rigid and min(joint.bodies) < 0 <= max(joint.bodies):
            at_body.setdefault(max(joint.bodies), []).append(k)
    for body, found in at_body.items():
        taken = [joints[k].removes for k in found]
        freedoms = [freedom for removes in taken if removes is not None for freedom in removes]
        if None in taken or not len(freedoms) == len(set(freedoms)) == FREEDOMS:
            continue
        first = joints[found[0]]
        same = all(
            np.allclose(joints[k].x, first.x, rtol=0.0, atol=1e-12)
            and np.allclose(joints[k].A, first.A, rtol=0.0, atol=1e-12)
            for k in found
        )
        if same:
            out[found] = body
    return out
