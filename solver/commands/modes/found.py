"""Modes about a state, with everything that is told of them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...linearisation.modes import Modes, modes_of
from ...linearisation.participation import Participation, participation, whirl_rates
from ...linearisation.sources import sources_of
from ...linearisation.state_space import StateSpace, linearise
from ...math.arrays import Array
from ...signals import sensors
from .state import State, States

_AT_REST = 1e-6  # accelerations of a state called an equilibrium, of those by loads
_ACCURATE = 1e-4  # estimated error of the differences without a note


@dataclass(frozen=True)
class Found:
    """Modes about one state."""

    state: State
    space: StateSpace
    modes: Modes
    shares: Participation
    whirl: Array  # (k,) angular frequencies seen from axes at rest; nan: no whirl
    notes: tuple[str, ...]


def find_modes(states: States, state: State, *, ports: bool = True) -> Found:
    """Linearise about a state and solve for its modes; `ports`: with inputs and outputs."""
    built, mechanism = states.built, states.spec.mechanism
    turning = state.spin is not None and state.spin.rate != 0.0
    W = state.spin.W if state.spin is not None else np.zeros(3)
    space = linearise(
        state.model,
        state.t,
        state.y,
        W,
        sensors=sensors(built, mechanism.signals) if ports else None,
        sources=sources_of(mechanism, built) if ports else (),
    )
    modes = modes_of(state.model, space, state.t)
    axis = state.spin.axis if state.spin is not None and turning else None
    shares = participation(state.model, space, modes, built.body_names, built.packages, axis)
    whirl = whirl_rates(modes, shares.forward, state.spin.rate if state.spin else 0.0)
    return Found(state, space, modes, shares, whirl, tuple(_notes(state, space, modes)))


def _notes(state: State, space: StateSpace, modes: Modes) -> list[str]:
    notes = []
    if space.rank.doubtful:
        notes.append(
            f"{space.rank.text}: these are close to each other. Whether the rows that they stand "
            "for follow from others is uncertain, and with it one mode"
        )
    off = float(np.linalg.norm(space.free.Z_left @ space.acceleration))
    loads = float(np.linalg.norm(space.forces / np.sqrt(state.model.inertia_scale)))
    if off > _AT_REST * max(loads, 1e-9):
        notes.append(
            "the state is no equilibrium: the modes are those of this instant, and hold for "
            "motions that are fast against the change of the state"
        )
    if space.error > _ACCURATE:
        notes.append(
            f"the accelerations are not smooth about this state (differences agree to "
            f"{space.error:.1g}): friction, stops or tables may have a corner there"
        )
    if modes.unstable.any():
        growth = float(modes.growth.max())
        notes.append(f"unstable: {int(modes.unstable.sum())} modes grow, at up to {growth:.4g} 1/s")
    return notes


def entries(found: Found, body_names: list[str]) -> list[dict[str, Any]]:
    """Return the modes as plain data."""
    out = []
    for k, value in enumerate(found.modes.eigenvalues):
        w = float(found.modes.frequencies[k])
        still = bool(found.modes.still[k])
        whirl = float(found.whirl[k])
        out.append(
            {
                "number": k + 1,
                "frequency_hz": w / (2.0 * np.pi),
                "angular_frequency": w,
                "damping_ratio": float(found.modes.damping[k]),
                "eigenvalue": [0.0, 0.0] if still else [float(value.real), float(value.imag)],
                "kind": "zero" if still else "oscillation" if w > 0.0 else "real",
                "fixed_axes_angular_frequency": None if np.isnan(whirl) else whirl,
                "main": found.shares.main[k],
                "bodies": {
                    name: float(share)
                    for name, share in zip(body_names, found.shares.bodies[:, k], strict=False)
                },
            }
        )
    return out
