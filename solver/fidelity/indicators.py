"""Indicators of a plan: what the omission of each mode, of static shapes and of stiffening costs.

Indicators plan, they certify nothing: a zero indicator is no evidence. The check run certifies.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ..math.arrays import Array
from ..package import ModalPackage
from ..package.body.selection import vibrations
from ..run.outcome import RunSpec
from ..run.timing import work_s
from ..signals import sensors
from .base import Base, base_motion
from .effects import Effects, effects
from .loaded import Loaded, fixed_packages, loaded
from .metrics import difference, scales
from .model import Rich
from .response import response
from .rounding import kind_of_signal, relatives
from .stiffening import spins, stiffening_loss
from .tolerance import amplified_errors


@dataclass(frozen=True)
class Mode:
    """A mode of a rich package: body, label, and whether it is a vibration."""

    body: str
    label: str
    vibration: bool


@dataclass(frozen=True)
class Indicators:
    """Losses by mode and kind.

    Attributes
    ----------
    names : signals
    scale : (o,) size of each signal
    modes : m of the modes that respond
    effects : their contributions
    stiffening : (o,) loss without geometric stiffening, of the scale
    spin : largest spin over the first frequency of the clamped body, by body
    amplified : (o,) error of each signal over the tolerance that causes it
    quiet : (o,) the signals that are rounding; their scale is the size of what they are near
    """

    names: list[str]
    metric: str
    scale: Array
    modes: list[Mode]
    effects: Effects
    stiffening: Array
    spin: dict[str, float]
    amplified: Array
    quiet: npt.NDArray[np.bool_]

    def loss(self, lost: Array) -> Array:
        """Return the error (..., o) that lost contributions (..., o, k) cause, of the scale."""
        whole = self.effects.whole
        return difference(self.metric, whole, whole - lost) / self.scale

    def worth(self, static: Mapping[str, bool]) -> Array:
        """Return the loss of each mode alone, the largest of all signals, (m,)."""
        lost = self.effects.response - self.effects.static * self._has(static)
        size = np.abs(lost).max(axis=1) / self.scale[:, None]
        return np.asarray(size.max(axis=0, initial=0.0))

    def _has(self, static: Mapping[str, bool]) -> Array:
        return np.array([float(static.get(mode.body, False)) for mode in self.modes])

    def ranked(self, body: str) -> tuple[str, ...]:
        """Return the labels of the vibrations of a body, largest loss first."""
        worth = self.worth({})
        order = np.argsort(-worth, kind="stable")
        mine = [self.modes[i] for i in order.tolist()]
        return tuple(mode.label for mode in mine if mode.body == body and mode.vibration)


@dataclass(frozen=True)
class Study:
    """The base motion, the rich packages with their quasi-static response, the indicators.

    Attributes
    ----------
    of_check : returns the rich packages of the check, which indicators do not need
    cpu : seconds of the base motion and of the indicators
    """

    base: Base
    model: dict[str, Rich]
    of_check: Callable[[], dict[str, Rich]]
    indicators: Indicators
    cpu: dict[str, float]

    @cached_property
    def check(self) -> dict[str, Rich]:
        """The rich packages of the check."""
        return self.of_check()


def study(
    spec: RunSpec, check: Mapping[str, ModalPackage], names: list[str], signals: list[str]
) -> Study:
    """Return what a plan is made from.

    Parameters
    ----------
    spec : the run with the rich packages of the model
    check : rich packages of the check
    names : flexible bodies that the plan is about
    signals : names of the signals that must be accurate
    """
    begin = work_s()
    base = base_motion(spec, names)
    moved = work_s()
    fixed = fixed_packages(spec, base, names)

    def of(packages: Mapping[str, ModalPackage]) -> Loaded:
        return loaded(spec, base, {name: packages[name] for name in names}, fixed)

    model = of(spec.packages)
    found = _indicators(spec, base, model, signals)
    cpu = {"base": moved - begin, "indicators": work_s() - moved}
    return Study(base, model.rich, lambda: of(check).rich, found, cpu)


def _indicators(spec: RunSpec, base: Base, model: Loaded, signals: list[str]) -> Indicators:
    fidelity = spec.mechanism.fidelity
    assert fidelity is not None
    built, modes = model.built, []
    for name in built.body_names:
        if name in model.rich:
            package = model.rich[name].package
            moving = set(vibrations(package).tolist())
            modes += [
                Mode(name, package.mode_labels[j], j in moving) for j in model.modes[name].tolist()
            ]
    deformed = spec.mechanism.solver.start != "positions"
    found = response(base, built.model, model.p, deformed=deformed)
    wanted = {name: spec.mechanism.signals[name] for name in signals}
    compared = relatives(signals, spec.mechanism, built, found.y[0])
    measured = compared.sensors(built)
    kinds = {name: kind_of_signal(name, compared.table) for name in measured}
    every = effects(found, measured, kinds)
    whole, sizes = compared.judged(dict(zip(measured, every.whole, strict=True)))
    quiet = np.asarray(sizes > 0.0)
    scale = np.where(quiet, sizes, scales(fidelity.metric, whole))
    count = len(signals)  # relatives follow
    parts = Effects(every.base[:count], every.response[:count], every.static[:count])
    measured = {name: measured[name] for name in signals}
    stiffened = np.zeros(len(signals))
    again = model.stiffened
    if again is not None:
        second = sensors(again, spec.mechanism.signals, wanted=wanted)
        lost = stiffening_loss(found, again, measured, second, parts)
        stiffened = np.abs(lost).max(axis=1) / scale
    spin = spins(built, found, list(model.rich))
    amplified = amplified_errors(found, parts, scale)
    return Indicators(
        list(signals), fidelity.metric, scale, modes, parts, stiffened, spin, amplified, quiet
    )
