"""Modes about a state: what is reported, exported and computed as response; Campbell diagrams."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import compress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...checks.stability import SpinMonitor
from ...checks.statics import missed_by_modes
from ...checks.stiffening import tilting, tilting_text
from ...dynamics.analysis.recovery import Recording, body_frames, extent
from ...dynamics.evaluation.series import along_solution
from ...dynamics.model.coordinates import Spin, moved, spin_velocities, turned
from ...errors import InputError, counted, few, nearest
from ...math.arrays import Array, IntArray
from ...math.rotations import vector_to_matrix
from ...mechanism.built_mechanism import Start
from ...mechanism.equilibrium import after_turn, round_off
from ...package.common.plain_data import csv_text
from ...report.style import DASHES, GREY, WARNING, Canvas, colour, house_style
from ...results.codes import TILTING
from ...signals import sensors
from ..linearisation.campbell import Campbell, Point, crossings, follow, vectors_of
from ..linearisation.differences import STEP, units_of
from ..linearisation.modes import (
    Modes,
    Participation,
    change_when_turned,
    modes_of,
    participation,
    whirl_rates,
)
from ..linearisation.state_space import (
    StateSpace,
    common_spin,
    frequencies_between,
    frequency_response,
    linearise,
    sources_of,
)
from ..tolerances import ACCURATE_DIFFERENCES, AT_REST, BENT, CONSTANT_EQUATIONS, TURNS_FREELY
from .state import State, States

# Modes about a state, with everything that is reported about them.

_TURNS = (0.8, 1.6)  # [rad] angles at which equations are compared
_JUDGED = 6  # of the lowest frequencies: the highest of any model lack shapes


class Mode(NamedTuple):
    """A mode, as modes.json has it."""

    number: int
    frequency_hz: float
    angular_frequency: float
    damping_ratio: float
    eigenvalue: list[float]  # [1/s]
    kind: str  # zero, oscillation, real
    fixed_axes_angular_frequency: float | None
    main: str
    bodies: dict[str, float]  # shares of the kinetic energy


@dataclass(frozen=True)
class Found:
    """Modes about one state."""

    states: States
    state: State
    space: StateSpace
    modes: Modes
    shares: Participation
    whirl: Array  # (k,) angular frequencies seen from axes at rest; nan: no whirl

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What a reader should know of the state and of the modes; a design does not ask for it."""
        return tuple(_notes(self.states, self.state, self.space, self.modes))

    @cached_property
    def each(self) -> list[Mode]:
        """The modes, from the lowest on."""
        return [self._mode(k) for k in range(len(self.whirl))]

    def _mode(self, k: int) -> Mode:
        value, w = self.modes.eigenvalues[k], float(self.modes.frequencies[k])
        still, whirl = bool(self.modes.still[k]), float(self.whirl[k])
        shares = self.shares.bodies[:, k].tolist()
        return Mode(
            k + 1,
            w / (2.0 * np.pi),
            w,
            float(self.damping[k]),
            [0.0, 0.0] if still else [float(value.real), float(value.imag)],
            "zero" if still else "oscillation" if w > 0.0 else "real",
            None if np.isnan(whirl) else whirl,
            self.shares.main[k],
            dict(zip(self.states.built.body_names, shares, strict=False)),
        )

    @property
    def damping(self) -> Array:
        """Damping ratios (k,) [-]: of a whirl in axes at rest, where its forces stand."""
        decay, whirl = -self.modes.eigenvalues.real, np.nan_to_num(self.whirl)
        size = np.hypot(decay, whirl)
        return np.where(whirl != 0.0, decay / np.where(size > 0.0, size, 1.0), self.modes.damping)


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

    def linearised(W: Array, turning: Array | None = None) -> tuple[StateSpace, Modes]:
        space = linearise(
            state.model,
            state.t,
            state.y,
            W,
            sensors=sensors(built, mechanism.signals) if ports else None,
            sources=sources_of(mechanism, built) if ports else (),
        )
        return space, modes_of(state.model, space, state.t, turning)

    turning = None
    if state.spin is not None and (state.given_spin or _turns_freely(state, state.spin)):
        turning = spin_velocities(state.model, state.y, state.spin._replace(rate=1.0))
    space, modes = linearised(np.zeros(3) if spin is None else spin.W, turning)
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
    shares = participation(state.model, built, space, modes, axis)
    whirl = whirl_rates(modes, shares.forward, spin.rate if spin is not None else 0.0)
    return Found(states, state, space, modes, shares, whirl)


def _turns_freely(state: State, spin: Spin) -> bool:
    """Return whether the mechanism would turn on in the same way from turned positions."""
    model, y = state.model, state.y.copy()
    for angle in _TURNS:
        if spin.rate != 0.0:
            later = after_turn(model, state.y, spin, state.t, angle)
            if common_spin(later.model, state.t, later.y) is None:
                return False
            continue
        y[: model.n_pos] = turned(model, state.y[: model.n_pos], spin, angle)
        a = along_solution(model, np.full(1, state.t), y[None])[0][0, model.n_pos :]
        if np.abs(a[: model.n_vel]).max() > TURNS_FREELY * max(1.0, extent(model, y)):
            return False
    return True


def _changes(state: State, space: StateSpace, modes: Modes, spin: Spin) -> bool:
    """Return whether the equations change while the mechanism turns."""
    for angle in _TURNS:
        later = after_turn(state.model, state.y, spin, state.t, angle)
        there = linearise(later.model, state.t, later.y, spin.W)
        A = vector_to_matrix(angle * spin.axis)
        if change_when_turned(state.model, space, modes, there, A, spin.rate) > CONSTANT_EQUATIONS:
            return True
    return False


def _notes(states: States, state: State, space: StateSpace, modes: Modes) -> list[str]:
    notes = []
    if space.rank.doubtful:
        notes.append(
            f"{space.rank.text}: these are close to each other. Whether the rows that they stand "
            "for follow from others is uncertain, and with it one mode"
        )
    left = space.free.Z_left @ space.acceleration
    off = float(np.linalg.norm(left))
    loads = float(np.linalg.norm(space.forces / np.sqrt(state.model.inertia_scale)))
    if state.spin is not None:  # a balanced rotor has no loads but round-off
        v = spin_velocities(state.model, state.y, state.spin)
        loads = max(loads, state.spin.rate * float(np.sqrt(v @ space.mass @ v)))
        turn = space.free.Z_left @ v  # what drives the spin is not asked for
        if (
            state.given_spin
            and np.abs(space.free.Z @ turn - v).max() < TURNS_FREELY * np.abs(v).max()
        ):
            force = space.free.Z.T @ space.mass @ space.free.Z @ left
            off = float(np.linalg.norm(force - turn * (turn @ force) / (turn @ turn)))
    n = space.n_free
    noise = round_off(state.model, state.y, 0.0, space.A_free[n : 2 * n, :n], space.free)
    least = float(np.linalg.norm(noise * np.sqrt(state.model.inertia_scale)))
    if off > max(AT_REST * max(loads, 1e-9), least):
        notes.append(
            "the state is no equilibrium: the modes are those of this instant, and hold for "
            "motions that are fast against the change of the state"
        )
    elif np.abs(space.auxiliary_rates).max(initial=0.0) > AT_REST:
        names = [states.built.state_names[j] for j in space.auxiliary]
        moving = np.abs(space.auxiliary_rates) > AT_REST
        some = ", ".join(n for n, moves in zip(names, moving, strict=True) if moves)
        notes.append(
            f"the state is no equilibrium: {some} still changes. --at t=TIME takes a time after it "
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
            f"{BENT:g} rad relative to the body frame. The elastic law is that of the undeformed "
            "body, and frequencies may be a per cent off; a beam divided by `segments` has less"
        )
    notes += _missed(states, state, space, modes)
    if states.tables is not None and state.spin is not None and state.spin.rate != 0.0:
        spin, packages = SpinMonitor(state.model, states.built.body_names), states.built.packages
        for i, name in enumerate(states.built.body_names):
            if name in packages and packages[name].second_order is not None:
                part = tilting(spin, states.tables, i, state.y)
                notes += [f"{name}: {tilting_text(part)}"] if part > TILTING.limit else []
    if space.error > ACCURATE_DIFFERENCES:
        notes.append(
            f"the accelerations are not smooth about this state (differences agree to "
            f"{space.error:.1g}): friction, stops or tables may have a corner there"
        )
    if modes.unstable.any():
        growth = float(modes.growth.max())
        count = int(modes.unstable.sum())
        text = counted(count, "mode grows", "modes grow")
        notes.append(f"unstable: {text}, at up to {growth:.4g} 1/s")
    return notes


def _bent(states: States, state: State) -> list[str]:
    """Return the flexible bodies whose interfaces turn by more than BENT in a state."""
    built, bodies = states.built, []
    for i, name in enumerate(built.body_names):
        package = built.packages.get(name)
        if package is not None and state.model.n_mode[i] == package.n_mode:
            _, _, q = body_frames(state.model, i, state.y[None])
            linear = [place.psi_B @ q[0] for place in package.interfaces]
            if max((float(np.linalg.norm(turn)) for turn in linear), default=0.0) > BENT:
                bodies.append(name)
    return bodies


def _missed(states: States, state: State, space: StateSpace, modes: Modes) -> list[str]:
    """Return which of the lowest frequencies are too high, as bodies lack shapes for their loads.

    The loads on the bodies in a mode are differences of those of states a step to both sides. Not
    of a spin, whose frequencies in turning axes say nothing of the energy of a mode.
    """
    model, y, motions = state.model, state.y, []
    if state.spin is not None and state.spin.rate != 0.0:
        return []
    unit = units_of(model, extent(model, y))
    for k in np.flatnonzero(modes.frequencies > 0.0)[:_JUDGED].tolist():
        x, rate = modes.x[:, k], modes.eigenvalues[k]
        x = x * (STEP / np.abs(x * unit).max())
        near = []
        for phase in (1.0, 1.0j, -1.0, -1.0j):
            at = moved(model, y[: model.n_pos], (x * phase).real)
            v = y[model.n_pos :].copy()
            v[: model.n_vel] += (rate * x * phase).real
            near.append(np.concatenate([at, v]))
        energy = 0.25 * abs(rate) ** 2 * float((x.conj() @ space.mass @ x).real)
        recording = Recording(model, np.full(len(near), state.t), np.array(near))
        motions.append((k + 1, recording, energy))
    return list(missed_by_modes(states.built, motions))


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
    result: Found, span: tuple[float, float], inputs: list[str] | None, outputs: list[str] | None
) -> Response:
    """Return the transfer functions between named inputs and outputs.

    Parameters
    ----------
    result : modes about a state
    span : lowest and highest frequency [Hz]
    inputs : names of inputs; None: all
    outputs : names of outputs; None: all

    Raises
    ------
    InputError
        An unknown name; a case without inputs or signals.
    """
    space = result.space
    into = _chosen("--input", inputs, [s.name for s in space.inputs], "drive, load or actuator")
    out = _chosen("--output", outputs, [name for name, _ in space.outputs], "signal")
    low, high = (2.0 * np.pi * f for f in span)
    w = frequencies_between(low, high, POINTS, result.modes.frequencies)
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


# Campbell diagram of a case: relative equilibria and modes over a range of speeds.

RPM = 30.0 / np.pi
# A whirl at the speed itself stands still in axes that turn, and has no direction: the modes are
# then those of a speed so much higher, the first at which it moves.
_BESIDE = (1e-6, 1e-5, 1e-4)


class Spins:
    """Modes of a case at any speed, each equilibrium found from one nearby."""

    def __init__(self, states: States, axis: Array | None) -> None:
        self.states, self.line = states, states.spin(axis)
        self.start = states.start()
        self.notes: dict[str, None] = {}
        self._known: dict[int, State] = {}
        self._checked = False

    def at(self, speed: float, near: Point | None) -> Point:
        """Return the modes at a speed [rad/s]; `near` are those of a speed nearby."""
        start = self.start
        if near is not None:
            positions = self._known[id(near.modes)].y[: self.states.built.model.n_pos]
            start = Start(positions, start.velocities, start.given)
        result = self._found(speed, start)
        if near is not None and speed != 0.0:
            for off in _BESIDE:
                if result.modes.still.sum() <= near.modes.still.sum():
                    break
                result = self._found(speed * (1.0 + off), start)
        for note in result.notes:
            if not note.startswith("unstable"):
                self.notes[note] = None
        self._known[id(result.modes)] = result.state
        fixed = result.modes.frequencies if speed == 0.0 else result.whirl
        vectors = vectors_of(result.space, result.modes)
        return Point(speed, result.modes, vectors, fixed, result.damping, result.shares.main)

    def _found(self, speed: float, start: Start) -> Found:
        state = self.states.turning(self.line._replace(rate=speed), start)
        check = speed != 0.0 and not self._checked
        result = find_modes(self.states, state, ports=False, check=check)
        self._checked = self._checked or check
        return result


class Branch(NamedTuple):
    """A branch of a Campbell diagram at the speeds that were asked for; None: not known."""

    branch: int
    main: str
    angular_frequency: list[float | None]
    fixed_axes_angular_frequency: list[float | None]
    damping_ratio: list[float | None]
    growth: list[float | None]
    mode: list[int | None]

    def seen(self, fixed: bool) -> list[float | None]:
        """Angular frequencies from axes at rest, or from those that turn."""
        return self.fixed_axes_angular_frequency if fixed else self.angular_frequency


class Diagram:
    """A Campbell diagram and its crossings."""

    def __init__(self, spins: Spins, speeds: Array, most: int, harmonics: int, axes: str) -> None:
        self.spins, self.speeds, self.harmonics = spins, speeds, harmonics
        self.campbell: Campbell = follow(spins.at, speeds, most)
        whirl = np.isfinite(self.campbell.fixed) | np.isnan(self.campbell.frequencies)
        # All modes circle the axis: a rotor, whose forces stand in axes at rest.
        self.fixed = axes == "fixed" or (axes == "auto" and bool(whirl.all()))
        self.crossings = crossings(self.campbell, spins.at, harmonics, fixed=self.fixed)

    @property
    def names(self) -> list[str]:
        """Names of the branches; whirls with their direction at the last speed."""
        c, names = self.campbell, []
        for name, w, fixed in zip(c.names, c.frequencies.T, c.fixed.T, strict=True):
            known = np.flatnonzero(np.isfinite(fixed) & (c.speeds > 0.0))
            if self.fixed and known.size and fixed[known[-1]] != w[known[-1]]:
                name += ", forward" if fixed[known[-1]] > 0.0 else ", backward"
            names.append(name)
        return names

    @property
    def asked(self) -> IntArray:
        """Rows of the speeds that were asked for, without those put between."""
        return np.searchsorted(self.campbell.speeds, self.speeds).astype(np.int64)

    @property
    def branches(self) -> list[Branch]:
        """The branches, from the lowest on."""
        c, rows = self.campbell, self.asked
        return [
            Branch(
                b + 1,
                name,
                _plain(c.frequencies[rows, b]),
                _plain(c.fixed[rows, b]),
                _plain(c.damping[rows, b]),
                _plain(c.growth[rows, b]),
                [int(n) + 1 if n >= 0 else None for n in c.modes[rows, b]],
            )
            for b, name in enumerate(self.names)
        ]

    def content(self) -> dict[str, Any]:
        """Return the content of campbell.json."""
        spec = self.spins.states.spec
        return {
            "case": spec.case,
            "run": spec.run,
            "axis": self.spins.line.axis.tolist(),
            "axes": "fixed" if self.fixed else "turning",
            "speeds": self.campbell.speeds[self.asked].tolist(),
            "branches": [branch._asdict() for branch in self.branches],
            "crossings": [
                {
                    "branch": x.branch + 1,
                    "main": self.names[x.branch],
                    "harmonic": x.harmonic,
                    "speed": x.speed,
                    "rpm": x.speed * RPM,
                    "angular_frequency": x.frequency,
                }
                for x in self.crossings
            ],
            "least_overlap": float(np.nanmin(self.campbell.overlaps, initial=1.0)),
            "notes": list(self.spins.notes),
        }

    def csv(self) -> str:
        """Return the table of campbell.csv."""
        c, names = self.campbell, [f"{b + 1} {name}" for b, name in enumerate(self.names)]
        head = ["speed [rad/s]", *(f"{n} [rad/s]" for n in names)]
        head += [f"{n} fixed axes [rad/s]" for n in names] + [f"{n} damping [-]" for n in names]
        table = np.column_stack([c.speeds, c.frequencies, c.fixed, c.damping])[self.asked]
        rows = [["" if np.isnan(v) else v for v in row] for row in table.tolist()]
        return csv_text([head, *rows], "\n")


def _plain(values: Array) -> list[float | None]:
    return [None if np.isnan(v) else float(v) for v in values]


# Figure of a Campbell diagram.

_REACH, _FEW = 1.5, 4  # branches drawn: up to so many times the harmonics, and the lowest ones
_APART = 0.045  # of the height: labels beside the diagram


def draw(path: Path, diagram: Diagram) -> Path:
    """Draw campbell.png: frequencies of the branches over speed, harmonics and crossings."""
    c, hz = diagram.campbell, 2.0 * np.pi
    followed = diagram.campbell.followed(diagram.fixed) / hz
    lowest = np.where(followed > 0.0, followed, np.inf).min(axis=0)
    last = diagram.harmonics * c.speeds[-1] / hz
    known = np.sort(lowest[np.isfinite(lowest)])
    limit = max([_REACH * last, *known[:_FEW]])
    drawn = np.flatnonzero(lowest <= limit).tolist()
    top = 1.08 * float(np.nanmax(followed[:, drawn], initial=1e-3))
    with house_style():
        canvas = Canvas(7.2, 4.8)
        (axes,) = canvas.panels(1)
        labels: list[tuple[float, str, str]] = []  # beside the ends of lines: height, text, colour
        for n in range(1, diagram.harmonics + 1):
            axes.plot(c.speeds, n * c.speeds / hz, color=GREY, linewidth=0.8, linestyle=(0, (4, 2)))
            if (end := n * c.speeds[-1] / hz) <= top:
                labels.append((end, f"{n}P", GREY))
            else:
                axes.text(top * hz / n, top, f"{n}P ", color=GREY, fontsize=8, va="top", ha="right")
        for i, b in enumerate(drawn):
            name = diagram.names[b]
            line = DASHES[1] if name.endswith(", backward") else "-"
            style = {"color": colour(i), "linestyle": line, "label": f"{b + 1} {name}"}
            axes.plot(c.speeds, followed[:, b], **style)
            grows = np.where(c.growth[:, b] > 0.0, followed[:, b], np.nan)
            axes.plot(c.speeds, grows, ".", color=WARNING, markersize=4, zorder=4)
            if np.isfinite(followed[-1, b]):
                labels.append((followed[-1, b], f"{b + 1}", colour(i)))
        points = [(x.speed, x.frequency / hz) for x in diagram.crossings if x.frequency / hz < top]
        if points:
            axes.plot(*zip(*points, strict=True), "o", color="black", markersize=3.5, zorder=5)
        height = -1.0
        for at, text, ink in sorted(labels):
            height = max(at / top, height + _APART)
            where = (1.0, at / top), (1.03, height), "axes fraction"
            to = {"arrowstyle": "-", "color": ink, "linewidth": 0.4}
            axes.annotate(text, *where, color=ink, fontsize=8, va="center", arrowprops=to)
        axes.set_xlim(c.speeds[0], c.speeds[-1])
        axes.set_ylim(0.0, top)
        seen = "axes at rest" if diagram.fixed else "axes that turn"
        spec = diagram.spins.states.spec
        axes.set_title(f"{spec.case}, run {spec.run}: frequencies in {seen}")
        axes.set_xlabel("speed [rad/s]")
        axes.set_ylabel("frequency [Hz]")
        above = axes.secondary_xaxis("top", functions=(lambda w: w * RPM, lambda r: r / RPM))
        above.set_xlabel("speed [1/min]")
        if more := len(known) - len(drawn):
            axes.plot([], [], " ", label=f"{more} more: campbell.csv")
        axes.legend(loc="upper left", bbox_to_anchor=(1.08, 1.0))
        return canvas.save(path)
