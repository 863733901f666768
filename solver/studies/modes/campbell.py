"""Campbell diagram of a case: relative equilibria and modes over a range of speeds."""

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from ...math.arrays import Array, IntArray
from ...mechanism.consistent.initial import Start
from ...report.style import GREY, WARNING, Canvas, colour, house_style
from ..linearisation.campbell import Campbell, Crossing, Point, crossings, follow
from ..linearisation.tracking import vectors_of
from .found import find_modes
from .state import State, States

# Campbell diagram of a case: relative equilibria and modes over a range of speeds.

RPM = 30.0 / np.pi


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
        state = self.states.turning(self.line._replace(rate=speed), start)
        check = speed != 0.0 and not self._checked
        found = find_modes(self.states, state, ports=False, check=check)
        self._checked = self._checked or check
        for note in found.notes:
            if not note.startswith("unstable"):
                self.notes[note] = None
        self._known[id(found.modes)] = state
        fixed = found.modes.frequencies if speed == 0.0 else found.whirl
        vectors = vectors_of(found.space, found.modes)
        return Point(speed, found.modes, vectors, fixed, found.shares.main)


class Diagram:
    """A Campbell diagram and its crossings."""

    def __init__(self, spins: Spins, speeds: Array, most: int, harmonics: int, axes: str) -> None:
        self.spins, self.speeds, self.harmonics = spins, speeds, harmonics
        self.campbell: Campbell = follow(spins.at, speeds, most)
        whirl = np.isfinite(self.campbell.fixed) | np.isnan(self.campbell.frequencies)
        # All modes circle the axis: a rotor, whose forces stand in axes at rest.
        self.fixed = axes == "fixed" or (axes == "auto" and bool(whirl.all()))
        found = crossings(self.campbell, spins.at, harmonics, fixed=self.fixed)
        self.crossings: list[Crossing] = found

    @property
    def names(self) -> list[str]:
        """Names of the branches; whirls with their direction at the last speed."""
        names = []
        for name, w, fixed in zip(
            self.campbell.names, self.campbell.frequencies.T, self.campbell.fixed.T, strict=True
        ):
            known = np.flatnonzero(np.isfinite(fixed) & (self.campbell.speeds > 0.0))
            if self.fixed and known.size and fixed[known[-1]] != w[known[-1]]:
                name += ", forward" if fixed[known[-1]] > 0.0 else ", backward"
            names.append(name)
        return names

    @property
    def asked(self) -> IntArray:
        """Rows of the speeds that were asked for, without those put between."""
        return np.searchsorted(self.campbell.speeds, self.speeds).astype(np.int64)

    def content(self) -> dict[str, Any]:
        """Return the content of campbell.json."""
        c, spec = self.campbell, self.spins.states.spec
        rows = self.asked
        branches = []
        for b, name in enumerate(self.names):
            branches.append(
                {
                    "branch": b + 1,
                    "main": name,
                    "angular_frequency": _plain(c.frequencies[rows, b]),
                    "fixed_axes_angular_frequency": _plain(c.fixed[rows, b]),
                    "damping_ratio": _plain(c.damping[rows, b]),
                    "growth": _plain(c.growth[rows, b]),
                    "mode": [int(n) + 1 if n >= 0 else None for n in c.modes[rows, b]],
                }
            )
        return {
            "case": spec.case,
            "run": spec.run,
            "axis": self.spins.line.axis.tolist(),
            "axes": "fixed" if self.fixed else "turning",
            "speeds": c.speeds[rows].tolist(),
            "branches": branches,
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
            "least_overlap": float(np.nanmin(c.overlaps, initial=1.0)),
            "notes": list(self.spins.notes),
        }

    def csv(self) -> str:
        """Return the table of campbell.csv."""
        c, out = self.campbell, io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        names = [f"{b + 1} {name}" for b, name in enumerate(self.names)]
        head = ["speed [rad/s]", *(f"{n} [rad/s]" for n in names)]
        head += [f"{n} fixed axes [rad/s]" for n in names] + [f"{n} damping [-]" for n in names]
        writer.writerow(head)
        for row in self.asked.tolist():
            values = (c.speeds[row : row + 1], c.frequencies[row], c.fixed[row], c.damping[row])
            writer.writerow(
                ["" if np.isnan(v) else repr(float(v)) for part in values for v in part]
            )
        return out.getvalue()


def _plain(values: Array) -> list[float | None]:
    return [None if np.isnan(v) else float(v) for v in values]


# Figure of a Campbell diagram.


def draw(path: Path, diagram: Diagram) -> Path:
    """Draw campbell.png: frequencies of the branches over speed, harmonics and crossings."""
    c, hz = diagram.campbell, 2.0 * np.pi
    with house_style():
        canvas = Canvas(7.2, 4.8)
        (axes,) = canvas.panels(1)
        followed = diagram.campbell.followed(diagram.fixed) / hz
        top = 1.08 * float(np.nanmax(followed, initial=1e-3))
        for n in range(1, diagram.harmonics + 1):
            axes.plot(c.speeds, n * c.speeds / hz, color=GREY, linewidth=0.8, linestyle=(0, (4, 2)))
            end = min(c.speeds[-1], top * hz / n)
            axes.annotate(
                f"{n}P", (end, n * end / hz), color=GREY, fontsize=8, va="bottom", ha="right"
            )
        for b, name in enumerate(diagram.names):
            axes.plot(c.speeds, followed[:, b], color=colour(b), label=name)
            grows = c.growth[:, b] > 0.0
            axes.plot(
                c.speeds[grows], followed[grows, b], ".", color=WARNING, markersize=4, zorder=4
            )
        points = [(x.speed, x.frequency / hz) for x in diagram.crossings if x.frequency / hz < top]
        if points:
            axes.plot(*zip(*points, strict=True), "o", color="black", markersize=3.5, zorder=5)
        axes.set_xlim(c.speeds[0], c.speeds[-1])
        axes.set_ylim(0.0, top)
        seen = "axes at rest" if diagram.fixed else "axes that turn"
        spec = diagram.spins.states.spec
        axes.set_title(f"{spec.case}, run {spec.run}: frequencies in {seen}")
        axes.set_xlabel("speed [rad/s]")
        axes.set_ylabel("frequency [Hz]")
        above = axes.secondary_xaxis("top", functions=(lambda w: w * RPM, lambda r: r / RPM))
        above.set_xlabel("speed [1/min]")
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
        return canvas.save(path)
