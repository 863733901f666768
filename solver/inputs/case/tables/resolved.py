"""The resolved mechanism of a run: plain data in a file, typed in the program; its outputs."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

from ....errors import InputError
from ...common.messages import validated
from .beam_schema import BeamBody
from .body_schema import ShellBody, SolidBody
from .columns import RESOLVED
from .dotted_keys import put
from .schema import Mechanism

RIGID = 13  # coordinates and velocities of a body without modes, kept at each output


def output_findings(mechanism: Mechanism) -> list[str]:
    """Return what is wrong with the outputs that a mechanism asks for, one line each."""
    solver = mechanism.solver
    key = f"solver.output_step = {solver.output_step:g}"
    if solver.output_step > solver.t_end:
        return [f"{key}: expected at most solver.t_end = {solver.t_end:g} s"]
    count = solver.t_end / solver.output_step
    if count <= solver.most_outputs:
        return []
    modes = sum(
        getattr(mode, "count", 1)
        for body in mechanism.bodies.values()
        if isinstance(body, BeamBody | ShellBody | SolidBody)
        for mode in body.modes
    )
    width = RIGID * len(mechanism.bodies) + 2 * modes
    size = f"{8.0 * width * count:.3g}" if isfinite(count) else "more than 1e308"
    return [
        f"{key}: {count:.4g} outputs up to t_end = {solver.t_end:g} s, which take at least {size} "
        f"bytes; expected at most solver.most_outputs = {solver.most_outputs}, which may be raised"
    ]


def resolved(table: Mapping[str, Any], where: str) -> Mechanism:
    """Return the mechanism of a run or sweep file, as `check` wrote it.

    Raises
    ------
    InputError
        A file that was not written by `check`, or by another version; `where` names it.
    """
    found = validated(Mechanism, table, where, **{RESOLVED: True})
    if wrong := output_findings(found):
        raise InputError("\n".join(f"{where}: {line}" for line in wrong))
    return found


def changed_mechanism(mechanism: Mechanism, changes: Mapping[str, Any]) -> Mechanism:
    """Return a mechanism with other values at dotted keys, checked like one from a file."""
    return resolved(put(mechanism.model_dump(), changes), "changed mechanism")
