"""Until when a pointwise promise holds: the time at which a tiny change has grown to the accuracy.

Chaotic motions amplify every error, and vibrations of slightly different frequency lose step. No
accuracy of the model is worth anything after that time.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ....errors import InputError
from ....package import ModalPackage
from ....run.integration import complete
from ....run.outcome import RunSpec
from ....run.preparation import prepare
from ....signals import Recording
from ..base.model import with_values
from .trial import Trial

CHANGE = 1e-6  # of the masses of the bodies, relative; another one for each body


def horizon(trial: Trial, names: list[str], accuracy: float) -> float | None:
    """Return the time [s] from which a signal of the changed run differs by `accuracy`.

    None if that is never, or if the changed run ends early.
    """
    spec = changed(trial.spec)
    try:
        prepared = prepare(spec.mechanism, spec.packages)
    except InputError:
        return None
    finished = complete(prepared)
    solution = finished.solution
    if solution.status != "finished" or not trial.complete:
        return None
    recording = Recording(finished.model, solution.t, solution.y)
    signals = np.array([prepared.measured[name].values(recording) for name in names])
    sizes = trial.scales("pointwise")
    far = np.flatnonzero((np.abs(signals - trial.signals) / sizes[:, None]).max(axis=0) > accuracy)
    return float(solution.t[far[0]]) if far.size else None


def changed(spec: RunSpec) -> RunSpec:
    """Return the run with masses changed by about CHANGE, differently for each body."""
    bodies = {}
    for i, (name, body) in enumerate(spec.mechanism.bodies.items()):
        factor = _factor(i)
        if body.kind == "rigid":
            inertia = [[factor * x for x in row] for row in body.inertia]
            body = with_values(body, mass=factor * body.mass, inertia=inertia)
        bodies[name] = body
    number = {name: i for i, name in enumerate(spec.mechanism.bodies)}
    packages: Mapping[str, ModalPackage] = {
        name: _heavier(package, _factor(number[name])) for name, package in spec.packages.items()
    }
    mechanism = with_values(spec.mechanism, bodies=bodies)
    return replace(spec, mechanism=mechanism, packages=dict(packages))


def _factor(i: int) -> float:
    return 1.0 + CHANGE * float(np.cos(1.0 + i))


def _heavier(package: ModalPackage, factor: float) -> ModalPackage:
    """Return a body of another density."""
    inv = package.invariants
    arrays = ("S0_B", "S_B", "T00_B", "T01_B", "T11_B", "J0_B", "J_psi_B")
    scaled = {name: factor * getattr(inv, name) for name in arrays}
    second = package.second_order
    if second is not None:
        tables = {name: factor * getattr(second, name) for name in ("Z0_B", "Z1_B", "G3", "G4")}
        second = replace(second, **tables)
    return replace(
        package,
        mass=factor * package.mass,
        invariants=replace(inv, mass=factor * inv.mass, **scaled),
        second_order=second,
    )
