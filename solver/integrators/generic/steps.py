"""Accepted steps in a row: what is looked at while an integrator runs."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from ...math.arrays import Array
from .base import Dense, Integrator

MOST_NOTED = 200  # steps noted one by one before they are looked at


@dataclass(frozen=True)
class StopRequest:
    """Ask the run to end at t_stop, inside one of the steps just taken."""

    t_stop: float  # [s]
    message: str
    code: str = ""


@dataclass(frozen=True)
class Steps:
    """k steps: step i goes from t[i], y[i] to t[i + 1], y[i + 1]."""

    t: Array  # (k + 1,) [s]
    y: Array  # (k + 1, n)
    _stand: Callable[[int], Integrator]

    def __len__(self) -> int:
        return self.t.size - 1

    def at(self, i: int) -> Integrator:
        """Return the integrator as it stood after step i.

        A step loop takes the steps up to there again: ask in ascending order.
        """
        return self._stand(i)

    def dense_output(self, i: int) -> Dense:
        """Solution inside step i."""
        return self.at(i).dense_output()

    def step_at(self, t: float) -> int:
        """Return the step in which time t lies; at the end of a step, that step."""
        return int(np.clip(np.searchsorted(self.t, t) - 1, 0, len(self) - 1))

    def until(self, t: float) -> "Steps":
        """Return the steps up to the one in which t lies."""
        last = self.step_at(t) + 2
        return replace(self, t=self.t[:last], y=self.y[:last])


class Watch(Protocol):
    """Looks at the steps of a run as they are taken, and may end it."""

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Look at steps; return the earliest reason to end the run."""

    @property
    def note(self) -> Callable[[float, Array], bool]:
        """Takes notice of a step that ends at t, y (n,), for integrators without strides.

        Returns whether it needs a look now. Without one, up to MOST_NOTED steps are shown together
        later, when only the last of them can be looked into.
        """


class EachStep:
    """Watch that calls a function of the integrator after each step."""

    def __init__(self, on_step: Callable[[Integrator], StopRequest | None]) -> None:
        self._on_step = on_step

    def note(self, t: float, y: Array) -> bool:
        """Every step needs a look."""
        return True

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Show the one step there is."""
        return self._on_step(steps.at(0))


class Noted:
    """Steps of an integrator that takes them one by one, kept to be looked at together."""

    def __init__(self, integrator: Integrator) -> None:
        self._integrator = integrator
        self._t, self._y = np.empty(MOST_NOTED + 1), np.empty((MOST_NOTED + 1, integrator.n))
        self.count = 0
        self._start()

    def _start(self) -> None:
        self._t[0], self._y[0] = self._integrator.t, self._integrator.y
        self.count = 0

    def add(self, t: float, y: Array) -> bool:
        """Keep a step that ends at t, y; tell whether there is no room for another."""
        self.count += 1
        self._t[self.count], self._y[self.count] = t, y
        return self.count == MOST_NOTED

    def taken(self) -> Steps:
        """Return the steps kept, and begin again."""
        last = self.count + 1
        steps = Steps(self._t[:last].copy(), self._y[:last].copy(), lambda i: self._integrator)
        self._start()
        return steps
