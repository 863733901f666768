"""The last stride of a compiled loop: its steps, taken again up to any of them."""

from abc import abstractmethod
from dataclasses import replace
from typing import Any

import numpy as np

from ..math.arrays import Array
from .compiled.step_control import Ends
from .generic import Integrator
from .generic.steps import Steps

PLACES = ("_begun", "_stood", "_ends")  # no part of what a loop goes on from


class StrideMemory(Integrator):
    """An integrator of many steps in one call that can stand after any step of the last call.

    It keeps all that the steps depend on at the beginning of a stride, and takes them again.
    """

    _workspace: Any  # of the compiled loop

    def _forget(self) -> None:
        """Begin without a stride."""
        nowhere = np.empty(0), np.empty((0, self.n))
        self._nowhere = *nowhere, 0, Ends(*nowhere)
        self._ends = self._nowhere[3]
        self._begun: Any = None  # mark of the beginning of the last stride
        self._stood: Any = None  # step of it after which the loop stands, mark of its end

    def steps_taken(self) -> Steps:
        """Return the steps of the last stride; valid up to the next."""
        return Steps(*self._ends_since(self._begun), self._stand)

    def _ends_since(self, mark: Any) -> tuple[Array, Array]:
        """Return times (k + 1,) and states (k + 1, n) of the k steps since `mark`, with its own."""
        begun = mark[0]
        taken = self.counters.steps - begun["counters"].steps
        t = np.append(begun["t"], self._ends.t[:taken])
        return t, np.concatenate((begun["y"][None, :], self._ends.y[:taken]))

    def _stand(self, i: int) -> Integrator:
        """Stand after step i of the last stride, by taking the steps up to there again."""
        if self._stood is None:
            self._stood = -1, self._mark()
            self._go_back(self._begun)
        stood, end = self._stood
        if i < stood:
            self._go_back(self._begun)
            stood = -1
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            for count in (i - stood - 1, 1 if i > stood else 0):  # the last one by itself: t_old
                if count > 0:
                    code, _ = self._call(count, *self._nowhere)
                    self._take_over(code)
        self._stood = i, end
        return self

    def take_up(self) -> None:
        """Stand at the end of the last stride, however much of it was looked at."""
        if self._stood is not None:
            self._go_back(self._stood[1])
            self._stood = None

    def take_back(self, count: int) -> None:
        """Stand after the first `count` steps of the last stride: the others were not taken."""
        if count > 0:
            self._stand(count - 1)
            self._stood = count - 1, self._mark()
        else:
            self._go_back(self._begun)
            self._stood = None

    def _mark(self) -> Any:
        """Return all that the steps to come depend on."""
        kept = {name: value for name, value in vars(self).items() if name not in PLACES}
        kept |= {"counters": replace(self.counters), "hints": list(self.hints)}
        return kept, [
            (array, array.copy()) for array in self._workspace if isinstance(array, np.ndarray)
        ]

    def _go_back(self, mark: Any) -> None:
        kept, arrays = mark
        vars(self).update(kept | {"counters": replace(kept["counters"])})
        for array, values in arrays:
            array[...] = values

    @abstractmethod
    def _call(
        self, most: int, times: Array, rows: Array, filled: int, ends: Ends
    ) -> tuple[int, int]:
        """Call the compiled loop for `most` steps."""

    @abstractmethod
    def _take_over(self, code: int) -> None:
        """Bring state and counters up to date, and say why a loop came back early."""
