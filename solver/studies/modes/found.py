"""Modes about a state: what is reported, exported and computed as response."""

import csv
import io
from dataclasses import dataclass, replace
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from ...dynamics.analysis.recovery import body_frames
from ...dynamics.evaluation.spinning import Spin
from ...errors import InputError, counted, few, nearest
from ...math.arrays import Array
from ...math.rotations import vector_to_matrix
from ...mechanism.starting.relative_equilibrium import after_turn
from ...package.common.temporary import temporary_sibling, write_text
from ...report.style import Canvas, colour, house_style
from ...signals import sensors
from ..linearisation.constancy import change_when_turned
from ..linearisation.modes import Modes, modes_of
from ..linearisation.named_states import Realisation, realisation
from ..linearisation.participation import (
    Participation,
    coordinate_names,
    participation,
    whirl_rates,
)
from ..linearisation.response import frequencies_between, frequency_response
from ..linearisation.sources import sources_of
from ..linearisation.state_space import StateSpace, linearise
from .state import State, States

# Modes about a state, with everything that is reported about them.

_AT_REST = 1e-6  # accelerations of a state called an equilibrium, of those by loads
_TURNS = (0.8, 1.6)  # [rad] angles at which equations are compared
_CONSTANT = 1e-5  # change of the equations, over the eigenvalues, that counts as none
_BENT = 0.03  # [rad] elastic rotation of an interface without a note
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


def find_modes(states: States, state: State, *, ports: bool = True, check: bool = True) -> Found:
    """Linearise about a state and solve for its modes.

    Where the whole mechanism turns but its equations are not constant in axes that turn with it,
    axes at rest are taken, unless the state was asked for by its spin.

    Parameters
    ----------
    ports : with inputs and outputs
    check : whether the equations are constant in axes that turn

    Raises
    ------
    InputError
        `--at spin=...` of a mechanism whose equations are not constant in axes that turn with it.
    """
    built, mechanism = states.built, states.spec.mechanism
    spin = state.spin if state.spin is not None and state.spin.rate != 0.0 else None

    def linearised(W: Array) -> tuple[StateSpace, Modes]:
        space = linearise(
            state.model,
            state.t,
            state.y,
            W,
            sensors=sensors(built, mechanism.signals) if ports else None,
            sources=sources_of(mechanism, built) if ports else (),
        )
        return space, modes_of(state.model, space, state.t)

    space, modes = linearised(np.zeros(3) if spin is None else spin.W)
    if spin is not None and check and _changes(state, space, modes, spin):
        if state.given_spin:
            raise InputError(
                f"--at spin={spin.rate:g}: the equations are not constant in axes that turn with "
                "the mechanism: its supports differ in directions across the axis. Expected "
                "supports that are the same in all directions; or, for rigid rotors of equal "
                "transverse inertias, angular_velocity of the body and --at start: axes at rest"
            )
        state, spin = replace(state, spin=None), None
        space, modes = linearised(np.zeros(3))
    axis = spin.axis if spin is not None else None
    shares = participation(state.model, space, modes, built.body_names, built.packages, axis)
    whirl = whirl_rates(modes, shares.forward, spin.rate if spin is not None else 0.0)
    return Found(state, space, modes, shares, whirl, tuple(_notes(states, state, space, modes)))


def _changes(state: State, space: StateSpace, modes: Modes, spin: Spin) -> bool:
    """Tell whether the equations change while the mechanism turns."""
    for angle in _TURNS:
        later = after_turn(state.model, state.y, spin, state.t, angle)
        there = linearise(later.model, state.t, later.y, spin.W)
        A = vector_to_matrix(angle * spin.axis)
        if change_when_turned(state.model, space, modes, there, A) > _CONSTANT:
            return True
    return False


def _notes(states: States, state: State, space: StateSpace, modes: Modes) -> list[str]:
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
    elif np.abs(space.auxiliary_rates).max(initial=0.0) > _AT_REST:
        names = [states.built.state_names[j] for j in space.auxiliary]
        moving = np.abs(space.auxiliary_rates) > _AT_REST
        told = ", ".join(n for n, moves in zip(names, moving, strict=True) if moves)
        notes.append(
            f"the state is no equilibrium: {told} still changes. --at t=TIME takes a time after it "
            "has settled"
        )
    period = state.model.quantities.period
    if (period > 0.0).any():
        held = {n.partition(".")[0] for n in compress(states.built.state_names, period > 0.0)}
        notes.append(
            f"{few(sorted(held))}: sampled, so its output is held and the modes are those without "
            "its feedback; without sample_time they contain it, but for its delay of half a sample "
            "time"
        )
    bent = _bent(states, state)
    if bent:
        notes.append(
            f"{few(bent)}: deformed in this state so far that interfaces turn by more than "
            f"{_BENT:g} rad relative to the body frame. The elastic law is that of the undeformed "
            "body, and frequencies may be a per cent off; a beam divided by `segments` has less"
        )
    if space.error > _ACCURATE:
        notes.append(
            f"the accelerations are not smooth about this state (differences agree to "
            f"{space.error:.1g}): friction, stops or tables may have a corner there"
        )
    if modes.unstable.any():
        growth = float(modes.growth.max())
        count = int(modes.unstable.sum())
        words = counted(count, "mode grows", "modes grow")
        notes.append(f"unstable: {words}, at up to {growth:.4g} 1/s")
    return notes


def _bent(states: States, state: State) -> list[str]:
    """Return the flexible bodies whose interfaces turn by more than _BENT in a state."""
    built, found = states.built, []
    for i, name in enumerate(built.body_names):
        package = built.packages.get(name)
        if package is not None and state.model.n_mode[i] == package.n_mode:
            _, _, q = body_frames(state.model, i, state.y[None])
            linear = [place.psi_B @ q[0] for place in package.interfaces]
            if max((float(np.linalg.norm(turn)) for turn in linear), default=0.0) > _BENT:
                found.append(name)
    return found


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


# `--response`: transfer functions from forces and drives to signals.

POINTS = 400


@dataclass(frozen=True)
class Response:
    """Transfer functions over frequency."""

    hz: Array  # (k,)
    G: Array  # (k, n_out, n_in) complex
    inputs: list[tuple[str, str]]  # name and unit
    outputs: list[tuple[str, str]]


def span_of(text: str) -> tuple[float, float]:
    """Read LOW:HIGH of `--response` [Hz]. Raises InputError."""
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        low = high = np.nan
    if not 0.0 < low < high < np.inf:
        raise InputError(f"--response {text}: expected LOW:HIGH in Hz, 0 < LOW < HIGH")
    return low, high


def response_of(
    found: Found, span: tuple[float, float], inputs: list[str] | None, outputs: list[str] | None
) -> Response:
    """Return the transfer functions between named inputs and outputs; None: all of them.

    Raises
    ------
    InputError
        An unknown name; a case without inputs or signals.
    """
    space = found.space
    into = _chosen("--input", inputs, [s.name for s in space.inputs], "drive, load or actuator")
    out = _chosen("--output", outputs, [name for name, _ in space.outputs], "signal")
    low, high = (2.0 * np.pi * f for f in span)
    w = frequencies_between(low, high, POINTS, found.modes.frequencies)
    G = frequency_response(space, w)[:, out][:, :, into]
    pairs = [(space.inputs[k].name, space.inputs[k].unit) for k in into]
    return Response(w / (2.0 * np.pi), G, pairs, [space.outputs[k] for k in out])


def _chosen(option: str, names: list[str] | None, known: list[str], what: str) -> list[int]:
    if not known:
        raise InputError(f"--response: the case has no {what}")
    for name in names or ():
        if name not in known:
            raise InputError(f"{option} {name}: no such {what}{nearest(name, known)}")
    return [known.index(name) for name in names or known]


def write_response(folder: Path, response: Response) -> None:
    """Write response.csv (magnitude and phase of each pair) and response.png."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    head, columns = ["frequency [Hz]"], [response.hz]
    for i, (output, unit) in enumerate(response.outputs):
        for j, (name, by) in enumerate(response.inputs):
            head += [f"{name} -> {output} [{unit} / ({by})]", f"{name} -> {output} phase [deg]"]
            g = response.G[:, i, j]
            columns += [np.abs(g), np.degrees(np.angle(g))]
    writer.writerow(head)
    writer.writerows([[repr(float(v)) for v in row] for row in np.array(columns).T])
    write_text(folder / "response.csv", out.getvalue())
    _draw(folder / "response.png", response)


def _draw(path: Path, response: Response) -> None:
    n = len(response.outputs)
    with house_style():
        canvas = Canvas(7.2, 0.6 + 2.4 * n)
        panels = canvas.panels(n, 2, sharex=True, width_ratios=(3, 2))
        for i, (output, unit) in enumerate(response.outputs):
            size, phase = panels[2 * i], panels[2 * i + 1]
            for j, (name, by) in enumerate(response.inputs):
                g = response.G[:, i, j]
                label = f"{name} [{by}]"
                size.loglog(
                    response.hz, np.maximum(np.abs(g), 1e-300), color=colour(j), label=label
                )
                phase.semilogx(response.hz, np.degrees(np.angle(g)), color=colour(j))
            size.set_title(f"{output} [{unit}] per unit of input")
            phase.set_title("phase [deg]")
            phase.set_ylim(-190.0, 190.0)
            phase.set_yticks((-180, -90, 0, 90, 180))
            size.legend(loc="best")
        for axes in panels[-2:]:
            axes.set_xlabel("frequency [Hz]")
        canvas.save(path)


# Linearised equations as files for NumPy and MATLAB.


def write_linear(folder: Path, states: States, found: Found) -> Realisation:
    """Write linear.npz and linear.mat: A, B, C, D with names and units of what they connect."""
    built = states.built
    names = coordinate_names(built.model, built.body_names, built.packages)
    system = realisation(found.space, names, built.state_names)
    matrices: dict[str, Any] = {key: getattr(system, key) for key in "ABCD"}
    words = {
        "states": system.states,
        "inputs": system.inputs,
        "input_units": system.input_units,
        "outputs": system.outputs,
        "output_units": system.output_units,
    }
    modes = {
        "eigenvalues": found.modes.eigenvalues,
        "shapes": found.modes.x,
        "t": np.array(found.state.t),
        "spin": found.state.spin.W if found.state.spin is not None else np.zeros(3),
    }
    texts = {key: np.array(value, dtype=str) for key, value in words.items()}
    coordinates = np.array(names, dtype=str)
    with temporary_sibling(folder / "linear.npz") as temporary:
        content: dict[str, Any] = {**matrices, **texts, **modes, "coordinates": coordinates}
        np.savez(temporary, **content)
    cells = {key: np.array(value, dtype=object)[:, None] for key, value in words.items()}
    cells["coordinates"] = np.array(names, dtype=object)[:, None]
    with temporary_sibling(folder / "linear.mat") as temporary:
        savemat(temporary, {**matrices, **cells, **modes}, do_compression=True)
    return system
