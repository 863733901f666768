"""`--at`: the state about which a mechanism is linearised."""

from math import isfinite, nan
from typing import TYPE_CHECKING, NamedTuple

from ...errors import InputError

if TYPE_CHECKING:
    from ...math.arrays import Array

_EXPECTED = (
    "expected start, equilibrium, t=TIME, spin=SPEED or spin=FIRST:LAST:STEP (rad/s; rpm if it "
    "ends in rpm)"
)
_MOST = 2000  # speeds


class At(NamedTuple):
    """What `--at` says."""

    kind: str  # start, equilibrium, time, spin
    time: float = 0.0  # [s]
    speeds: "Array | None" = None  # (k,) rising [rad/s]


def at_of(text: str) -> At:
    """Read the value of `--at`. Raises InputError."""
    word, equals, value = text.partition("=")
    if not equals and word in ("start", "equilibrium"):
        return At(word)
    if equals and word == "t":
        return At("time", time=_number(text, value))
    if equals and word == "spin":
        return At("spin", speeds=_speeds(text, value))
    raise InputError(f"--at {text}: {_EXPECTED}")


def _number(text: str, value: str) -> float:
    try:
        number = float(value)
    except ValueError:
        number = nan
    if not isfinite(number):
        raise InputError(f"--at {text}: {value!r} is not a number; {_EXPECTED}")
    return number


def _speeds(text: str, value: str) -> "Array":
    import numpy as np  # here: the command line begins with this file

    rpm = value.endswith("rpm")
    parts = [_number(text, part) for part in value.removesuffix("rpm").split(":")]
    unit = np.pi / 30.0 if rpm else 1.0
    if len(parts) == 1:
        return np.array(parts) * unit
    if len(parts) not in (2, 3):
        raise InputError(f"--at {text}: {_EXPECTED}")
    first, last = parts[:2]
    step = parts[2] if len(parts) == 3 else (last - first) / 20.0
    if not last > first or not step > 0.0:
        raise InputError(f"--at {text}: expected FIRST below LAST and a positive STEP")
    count = int(np.floor((last - first) / step * (1.0 + 1e-12)))
    if count > _MOST:
        raise InputError(f"--at {text}: {count} steps; expected at most {_MOST}")
    speeds = first + step * np.arange(count + 1)
    if last - speeds[-1] > 1e-9 * last:
        speeds = np.append(speeds, last)
    return np.asarray(speeds * unit)
