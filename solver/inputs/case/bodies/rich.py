"""What `[fidelity]` checks and builds: two rich packages for each flexible body.

The plan takes the model from the first. The check run uses the second, which has a finer mesh, more
vibrations and all load shapes, because a check within one package cannot see what it lacks.
"""

from collections.abc import Mapping
from typing import Any

from ....errors import unknown
from ..tables.beam_schema import BeamBody
from ..tables.body_schema import Reducible, ShellBody
from ..tables.loaded import loaded_places
from ..tables.schema import Mechanism
from ..tables.signals import PlyStressSignal

# Vibrations of a beam by kind, of the model and of the check.
BEAM_VIBRATIONS = {"bending-xy": (4, 6), "bending-xz": (4, 6), "torsion": (2, 3), "axial": (2, 3)}
SHELL_VIBRATIONS = (12, 18)  # lowest, of any kind
LEAST_ELEMENTS = 24  # of the model: converged for its highest bending mode
FINER = 2  # elements of the check over those of the model


def check_fidelity(mechanism: Mechanism) -> list[str]:
    """Return what is wrong with `[fidelity]` of a run, one line each."""
    fidelity = mechanism.fidelity
    if fidelity is None:
        return []
    found = []
    for name in fidelity.signals or []:
        found += unknown("fidelity.signals", name, "signal", mechanism.signals)
    for name in fidelity.signals or mechanism.signals:
        signal = mechanism.signals.get(name)
        if isinstance(signal, PlyStressSignal) and signal.point is None:
            found.append(
                f"signals.{name}.point: missing; expected with [fidelity], because the point of "
                "the largest stress is another one in each run"
            )
    if not mechanism.signals:
        found.append("fidelity: expected at least one signal in the case")
    for name, body in mechanism.bodies.items():
        if isinstance(body, Reducible) and body.reduced is not None:
            found.append(
                f"bodies.{name}.reduced: expected none with [fidelity], which chooses the modes"
            )
    return found


def rich_bodies(name: str, mechanism: Mechanism) -> tuple[Any, Any]:
    """Return a flexible body as the model and the check of `[fidelity]` need it."""
    body: BeamBody | ShellBody = mechanism.bodies[name]  # type: ignore[assignment]
    return _rich(name, body, mechanism, 0), _rich(name, body, mechanism, 1)


def _rich(name: str, body: BeamBody | ShellBody, mechanism: Mechanism, which: int) -> Any:
    clamped = body.reference.places[0] if body.reference.kind == "clamped" else None
    loaded = loaded_places(name, mechanism)
    tables: list[dict[str, Any]]
    if body.kind == "beam":
        tables = [{"kind": k, "count": counts[which]} for k, counts in BEAM_VIBRATIONS.items()]
    else:
        tables = [{"kind": "lowest", "count": SHELL_VIBRATIONS[which]}]
    tables += [
        {"kind": "attachment", "at": place}
        for place in body.interfaces
        if place in loaded and place != clamped
    ]
    if body.reference.kind != "mean-axis":  # which carries them
        tables.append({"kind": "static-inertia"})
    tables.append({"kind": "static-axial"})
    content = {**body.model_dump(), "modes": tables}
    if body.kind == "beam":
        content["elements"] = max(body.elements, LEAST_ELEMENTS) * (FINER if which else 1)
    elif which:
        content["refine"] = body.refine + 1
    return type(body).model_validate(content)


CHECK = ".check"  # after the name of a body: its package of the check


def model_and_check(specs: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Separate what belongs to the bodies of a case from what belongs to their check packages."""
    check = {n.removesuffix(CHECK): s for n, s in specs.items() if n.endswith(CHECK)}
    return {n: s for n, s in specs.items() if not n.endswith(CHECK)}, check
