"""A signal of a run in Python: values over time, measures, arithmetic; its tables and curves."""

from collections.abc import Iterable, Sequence
from html import escape
from importlib import import_module
from numbers import Real
from typing import Any

import numpy as np

from ..solver.errors import InputError
from ..solver.math.arrays import Array
from ..solver.results import Signal as History
from ..solver.results import signal_summary
from ..solver.results.summary import spectrum as amplitude_spectrum

MOST_POINTS = 240  # of a curve: more are not seen
INK = "#0072B2"


class Markup(str):
    """Text that is HTML already."""


def text(value: object) -> str:
    """Return a value as HTML; numbers with six digits, None as a dash."""
    if isinstance(value, Markup):
        return value
    if isinstance(value, float | np.floating):
        return f"{value:.6g}"
    return "&ndash;" if value is None else escape(str(value))


def table(head: Sequence[str], rows: Iterable[Sequence[object]], caption: str = "") -> str:
    """Return a table; `head` names the columns.

    Parameters
    ----------
    head : names of the columns
    rows : values of each row
    caption : text above the table
    """
    top = "".join(f"<th>{escape(word)}</th>" for word in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{text(value)}</td>" for value in row) + "</tr>" for row in rows
    )
    title = f"<caption><b>{escape(caption)}</b></caption>" if caption else ""
    return f"<table>{title}<thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def curve(t: Array, values: Array, width: int = 260, height: int = 48) -> Markup:
    """Return a curve as an SVG picture without axes; values that are not finite leave gaps.

    Parameters
    ----------
    t : times (k,) [s]
    values : values (k,)
    width : width of the picture [px]
    height : its height [px]
    """
    t, values = np.asarray(t, dtype=float), np.asarray(values, dtype=float)
    known = np.isfinite(values)
    size = f'width="{width}" height="{height}" viewBox="0 0 {width} {height}"'
    if not known.any() or len(t) < 2:
        return Markup(f"<svg {size}></svg>")
    rows = np.unique(np.linspace(0, len(t) - 1, MOST_POINTS).astype(int))
    # with the extremes, which a thinned curve would miss
    peaks = [int(np.nanargmin(np.where(known, values, np.nan)))]
    peaks += [int(np.nanargmax(np.where(known, values, np.nan)))]
    rows = np.unique([*rows, *peaks])
    low, high = values[known].min(), values[known].max()
    x = 2 + (width - 4) * (t[rows] - t[0]) / ((t[-1] - t[0]) or 1.0)
    y = height - 2 - (height - 4) * (values[rows] - low) / ((high - low) or 1.0)
    parts, pen = [], "M"
    for u, v in zip(x, y, strict=True):
        if np.isfinite(v):
            parts.append(f"{pen}{u:.1f} {v:.1f}")
            pen = "L"
        else:
            pen = "M"
    path = f'<path d="{"".join(parts)}" fill="none" stroke="{INK}" stroke-width="1.3"/>'
    return Markup(f"<svg {size}>{path}</svg>")


def pandas() -> Any:
    """Return the package pandas. Raises ImportError with words on how to install it."""
    return _installed("pandas", "to_pandas()")


class Signal:
    """A quantity over the time of a run.

    Attributes
    ----------
    name, unit, description : text
    t, values : (k,) time [s] and values

    Examples
    --------
    >>> import plymotion as pm
    >>> angle = pm.run("pendulum.toml").signals["angle"]
    >>> angle
    <Signal angle [rad]: 101 values, 0 to 3.14>
    >>> round(angle.max, 2), round(angle.t_of_max, 2)
    (3.14, 0.97)
    >>> round((2.0 * angle).peak_to_peak / angle.peak_to_peak, 12)
    2.0
    """

    def __init__(self, name: str, unit: str, description: str, t: Array, values: Array) -> None:
        self.name, self.unit, self.description = name, unit, description
        self.t, self.values = np.asarray(t, dtype=float), np.asarray(values, dtype=float)

    @property
    def final(self) -> float:
        """Last value.

        >>> import plymotion as pm
        >>> round(pm.run("pendulum.toml").signals["angle"].final, 3)
        3.135
        """
        return float(self.values[-1])

    @property
    def min(self) -> float:
        """Smallest finite value; NaN if there is none.

        >>> import plymotion as pm
        >>> round(pm.run("pendulum.toml").signals["tip_z"].min, 2)
        -1.0
        """
        return self._measure("min")

    @property
    def max(self) -> float:
        """Largest finite value; NaN if there is none.

        >>> import plymotion as pm
        >>> round(pm.run("pendulum.toml").signals["angle"].max, 3)
        3.142
        """
        return self._measure("max")

    @property
    def t_of_min(self) -> float:
        """Time of the smallest finite value [s]; NaN if there is none.

        >>> import plymotion as pm
        >>> round(pm.run("pendulum.toml").signals["tip_z"].t_of_min, 2)
        0.48
        """
        return self._measure("t_min")

    @property
    def t_of_max(self) -> float:
        """Time of the largest finite value [s]; NaN if there is none.

        >>> import plymotion as pm
        >>> round(pm.run("pendulum.toml").signals["angle"].t_of_max, 2)
        0.97
        """
        return self._measure("t_max")

    @property
    def rms(self) -> float:
        """Root mean square over time (trapezoidal rule).

        >>> import plymotion as pm
        >>> round(pm.run("pendulum.toml").signals["angle"].rms, 3)
        1.982
        """
        return self._measure("rms")

    @property
    def peak_to_peak(self) -> float:
        """Largest minus smallest value.

        >>> import plymotion as pm
        >>> round(pm.run("pendulum.toml").signals["angle"].peak_to_peak, 3)
        3.142
        """
        return self._measure("peak_to_peak")

    def _measure(self, name: str) -> float:
        """Return a measure as tables and summary.json have it."""
        history = History(self.name, self.unit, self.description, self.values)
        value = signal_summary(history, self.t)[name]
        return value if isinstance(value, float) else np.nan

    def spectrum(self, window: str = "hann") -> tuple[Array, Array]:
        """Return frequencies [Hz] and amplitudes, (m,), see docs/python.md.

        >>> import plymotion as pm
        >>> f, amplitude = pm.run("pendulum.toml").signals["angle"].spectrum()
        >>> round(float(f[1]), 3), len(f) == len(amplitude)
        (0.99, True)
        """
        return amplitude_spectrum(self.t, self.values, window)

    def at(self, t: float | Array) -> Any:
        """Return values at other times, linear between output times; NaN outside.

        >>> import plymotion as pm
        >>> angle = pm.run("pendulum.toml").signals["angle"]
        >>> bool(abs(angle.at(0.005) - 0.5 * (angle.values[0] + angle.values[1])) < 1e-12)
        True
        """
        return np.interp(t, self.t, self.values, left=np.nan, right=np.nan)

    def plot(self, axes: Any = None, **style: Any) -> Any:
        """Draw the signal over time with matplotlib; return the axes.

        Parameters
        ----------
        axes : to draw into; None: the current ones of pyplot
        style : of `axes.plot`

        >>> import plymotion as pm
        >>> axes = pm.run("pendulum.toml").signals["angle"].plot()
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('time [s]', 'angle [rad]')
        """
        axes = pyplot().gca() if axes is None else axes
        axes.plot(self.t, self.values, **{"label": self.name, **style})
        axes.set(xlabel="time [s]", ylabel=f"{self.description or self.name} [{self.unit}]")
        return axes

    def to_pandas(self) -> Any:
        """Return a Series over time. Raises ImportError without pandas.

        >>> import plymotion as pm
        >>> series = pm.run("pendulum.toml").signals["angle"].to_pandas()
        >>> series.index.name, series.name
        ('t', 'angle')
        """
        pd = pandas()
        return pd.Series(self.values, index=pd.Index(self.t, name="t"), name=self.name)

    # Above that of NumPy's scalars, below that of arrays: np.float64(2.0) * signal is a signal.
    __array_priority__ = -1.0

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(self.values, dtype=dtype)

    def __len__(self) -> int:
        return len(self.values)

    def __add__(self, other: Any) -> "Signal":
        return self._combined("+", other)

    __radd__ = __add__

    def __sub__(self, other: Any) -> "Signal":
        return self._combined("-", other)

    def __rsub__(self, other: Any) -> "Signal":
        return -self + other

    def __mul__(self, factor: Any) -> "Signal":
        if not isinstance(factor, Real):
            return NotImplemented
        return Signal(f"{factor:g} {self.name}", self.unit, "", self.t, self.values * factor)

    __rmul__ = __mul__

    def __truediv__(self, divisor: float) -> "Signal":
        return self * (1.0 / divisor)

    def __neg__(self) -> "Signal":
        return Signal(f"-{self.name}", self.unit, "", self.t, -self.values)

    def __abs__(self) -> "Signal":
        return Signal(f"|{self.name}|", self.unit, "", self.t, np.abs(self.values))

    def _combined(self, sign: str, other: Any) -> "Signal":
        if isinstance(other, Signal):
            if other.unit != self.unit:
                raise InputError(
                    f"{self.name} {sign} {other.name}: expected the same unit, found "
                    f"{self.unit} and {other.unit}"
                )
            name, values = other.name, other.at(self.t)
        elif isinstance(other, Real):
            name, values = f"{other:g}", float(other)
        else:
            return NotImplemented
        total = self.values + values if sign == "+" else self.values - values
        return Signal(f"{self.name} {sign} {name}", self.unit, "", self.t, total)

    def __repr__(self) -> str:
        span = f"{self.min:.3g} to {self.max:.3g}" if np.isfinite(self.values).any() else "none"
        return f"<Signal {self.name} [{self.unit}]: {len(self)} values, {span}>"

    def _repr_html_(self) -> str:
        return signals_table([self])


def norm(*signals: Signal) -> Signal:
    """Return the square root of the sum of squares of signals of one run, at every time.

    Examples
    --------
    >>> import plymotion as pm
    >>> signals = pm.run("pendulum.toml").signals
    >>> distance = pm.norm(signals["tip_x"], signals["tip_z"])
    >>> round(distance.min, 9), round(distance.max, 9)   # the length of the rod
    (1.0, 1.0)
    """
    if not signals:
        raise InputError("norm(): expected at least one signal")
    first = signals[0]
    values = np.sqrt(sum(np.square(s.at(first.t)) for s in signals))
    for signal in signals:
        first._combined("+", signal)  # refuses other units
    name = f"norm({', '.join(signal.name for signal in signals)})"
    return Signal(name, first.unit, "", first.t, values)


def signals_table(signals: list[Signal], caption: str = "") -> str:
    """Return signals as an HTML table with their curves."""
    rows = [
        [s.name, s.unit, s.final, s.min, s.max, s.rms, curve(s.t, s.values)]
        if np.isfinite(s.values).any()
        else [s.name, s.unit, None, None, None, None, ""]
        for s in signals
    ]
    return table(["signal", "unit", "final", "min", "max", "rms", "over time"], rows, caption)


def pyplot() -> Any:
    """Return matplotlib's pyplot. Raises ImportError with words on how to install it."""
    return _installed("matplotlib.pyplot", "plot()")


def _installed(module: str, caller: str) -> Any:
    """Import a module. Raises ImportError with the `caller` that needs it."""
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise ImportError(
            f"{caller} needs {package}, which is not installed; expected pip install {package}"
        ) from error
