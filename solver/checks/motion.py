"""Elastic rotations: how far interfaces turn relative to the frame of their body."""

from collections.abc import Iterator

import numpy as np

from ..dynamics.recover import stiffened
from ..results.codes.motion import ROTATION
from ..results.finding import Finding
from .finished import FinishedRun


def motion_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield bodies whose interfaces turn too far for small elastic rotations."""
    for i, name in enumerate(run.built.body_names):
        if not run.model.n_mode[i]:
            continue
        rotation = max(
            float(np.max(np.linalg.norm(q @ interface.psi_B.T, axis=1)))
            for _, q in run.modes(i)
            for interface in run.packages[name].interfaces
        )
        if rotation > ROTATION.limit:
            text = _text(name, rotation, second_order=stiffened(run.model, i))
            yield ROTATION.finding(text, body=name, value=rotation)


def _text(name: str, rotation: float, *, second_order: bool) -> str:
    turn = f"{name}: an interface turns by {rotation:.2f} rad relative to the body frame "
    if second_order:
        return (
            f"{turn}(second-order body: below {ROTATION.limit:g} rad; expect an error of about "
            "2 % at 0.25 rad): use a chord or mean-axis frame, or split the body"
        )
    return f"{turn}(linear bodies: below {ROTATION.limit:g} rad): split the body or stiffen it"
