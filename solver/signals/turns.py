"""Turns of angles and orientations, counted on the accepted steps of a run."""

from collections.abc import Callable

import numpy as np

from ..dynamics.analysis.recovery import Recording
from ..dynamics.model.model import Model
from ..math.arrays import Array
from .sections import Values



class Turns:
    """Follows angles (k,) and rotation vectors (k, 3) from step to step.

    Between two output times there may be any number of turns; the steps of an integrator resolve
    them.

    Attributes
    ----------
    times : (k,) output times [s]
    """

    def __init__(self, model: Model) -> None:
        self.times: Array = np.zeros(0)
        self._model = model
        self._memory: dict[object, object] = {}
        self._followed: list[Values] = []
        self._last: list[tuple[Array, Array]] = []  # times and values of the last steps
        self._near: list[Array] = []  # values about which the outputs are

    def whole(self, values: Values) -> Values:
        """Return what gives the same values with the turns of all steps.

        values : gives them with the turns that its own times show
        """
        number = len(self._followed)
        self._followed.append(values)

        def found(recording: Recording) -> Array:
            value = values(recording)
            near = self._about(number, recording.t, value)
            one, about = (each.reshape(len(value), -1) for each in (value, near))
            size, far = np.linalg.norm(one, axis=1), np.linalg.norm(about, axis=1)
            turned = np.where((size > 0.0)[:, None], one, about)
            axis = turned / np.maximum(np.where(size > 0.0, size, far), 1e-300)[:, None]
            if value.ndim == 1:
                axis[:] = 1.0
            off = ((about - one) * axis).sum(axis=1) / (2.0 * np.pi)
            known, missing = np.isfinite(off), np.zeros(off.size)
            missing[known] = np.round(off[known])
            if known.any():  # behind the last step that was seen: as many as up to there
                last = np.maximum.accumulate(np.where(known, np.arange(off.size), 0))
                missing = missing[last]
            return (one + 2.0 * np.pi * missing[:, None] * axis).reshape(value.shape)

        return found

    def __call__(self, t: Array, y: Array) -> None:
        """Follow steps with the ends t (k + 1,), y (k + 1, n); the first is that of the last."""
        first = 1 if self._last else 0
        if t.size == first:
            return
        recording = Recording(self._model, t[first:], y[first:], self._memory)
        for number, values in enumerate(self._followed):
            found = values(recording)
            if not first:
                self._last.append((recording.t, found))
                self._near.append(np.full((self.times.size, *found.shape[1:]), np.nan))
            else:
                time, value = self._last[number]
                self._last[number] = (
                    np.concatenate([time[-1:], recording.t]),
                    np.concatenate([value[-1:], found]),
                )
            begin, end = np.searchsorted(self.times, self._last[number][0][[0, -1]])
            end += end < self.times.size and self.times[end] == recording.t[-1]
            self._near[number][begin:end] = self._between(number, self.times[begin:end])

    def _between(self, number: int, t: Array) -> Array:
        """Return values at times (k,) within the last steps."""
        time, value = self._last[number]
        columns = value.reshape(time.size, -1).T
        found = np.array([np.interp(t, time, column) for column in columns])
        return found.T.reshape(t.size, *value.shape[1:])

    def _about(self, number: int, t: Array, value: Array) -> Array:
        """Return values near those at times (k,); nan where no step was seen."""
        near = np.full(value.shape, np.nan)
        if not self._last:
            return near
        at = np.minimum(np.searchsorted(self.times, t), max(self.times.size - 1, 0))
        if self.times.size:
            known = self.times[at] == t
            near[known] = self._near[number][at[known]]
        time = self._last[number][0]
        recent = np.isnan(near.reshape(t.size, -1)[:, 0]) & (t >= time[0]) & (t <= time[-1])
        near[recent] = self._between(number, t[recent])
        return near
