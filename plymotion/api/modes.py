"""`plymotion.modes` and `plymotion.campbell`: modes of a run about a state, and over its speed."""

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..solver.errors import InputError
from ..solver.math.arrays import Array
from ..solver.studies.linearisation.state_space import Realisation
from ..solver.studies.modes.files import linear_system, modes_content, write_campbell, write_modes
from ..solver.studies.modes.place import At, at_of
from ..solver.studies.modes.state import States, spec_of_run
from ..solver.studies.modes.state_modes import Diagram, Spins, find_modes, response_of
from .case import Case
from .result import chosen, named, path_of
from .signal import pandas, pyplot, table


class Modes:
    """Modes of a run about a state; docs/modes-about-a-state.md.

    Attributes
    ----------
    numbers : the content of modes.json: state, constraints, modes, notes

    Examples
    --------
    >>> import plymotion as pm
    >>> modes = pm.modes("pendulum.toml", at="equilibrium")
    >>> modes
    <Modes pendulum/base about equilibrium: 0.609 Hz>
    """

    def __init__(self, states: States, at: At, axis: Array | None) -> None:
        self._found = find_modes(states, states.at(at, axis))
        self.numbers: dict[str, object] = modes_content(self._found)

    @property
    def frequencies(self) -> Array:
        """Frequencies (k,) of damped oscillation [Hz]; 0 where a mode does not oscillate.

        >>> import plymotion as pm
        >>> pm.modes("pendulum.toml", at="equilibrium").frequencies.round(3)
        array([0.609])
        """
        return np.array([mode.frequency_hz for mode in self._found.each])

    @property
    def damping(self) -> Array:
        """Damping ratios (k,) [-].

        >>> import plymotion as pm
        >>> bool(abs(pm.modes("pendulum.toml", at="equilibrium").damping[0]) < 1e-6)
        True
        """
        return np.array([mode.damping_ratio for mode in self._found.each])

    @property
    def names(self) -> list[str]:
        """Main coordinate of each mode, k words.

        >>> import plymotion as pm
        >>> len(pm.modes("pendulum.toml", at="equilibrium").names)
        1
        """
        return [mode.main for mode in self._found.each]

    @property
    def notes(self) -> list[str]:
        """What limits the meaning of the modes.

        >>> import plymotion as pm
        >>> pm.modes("pendulum.toml", at="equilibrium").notes
        []
        """
        return list(self._found.notes)

    @cached_property
    def system(self) -> Realisation:
        """Linearised equations: `A`, `B`, `C`, `D`, and names and units of what they connect.

        >>> import plymotion as pm
        >>> pm.modes("pendulum.toml", at="equilibrium").system.A.shape
        (2, 2)
        """
        return linear_system(self._found)

    def response(
        self,
        low: float,
        high: float,
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
    ) -> tuple[Array, Array]:
        """Return frequencies (k,) [Hz] and transfer functions (k, outputs, inputs), complex.

        Parameters
        ----------
        low, high : between these frequencies [Hz]
        inputs, outputs : names of drives or loads, and of signals; None: all

        Raises
        ------
        InputError
            An unknown name; a case without inputs or signals.

        >>> import plymotion as pm
        >>> pm.modes("pendulum.toml", at="equilibrium").response(0.1, 10.0)
        Traceback (most recent call last):
        plymotion.solver.errors.InputError: --response: the case has no drive, load or actuator
        """
        if not 0.0 < low < high < np.inf:
            raise InputError(f"response({low}, {high}): expected 0 < low < high in Hz")
        chosen = [None if names is None else list(names) for names in (inputs, outputs)]
        result = response_of(self._found, (low, high), *chosen)
        return result.hz, result.G

    def write(self, folder: str | Path, *, shapes: int = 6) -> list[Path]:
        """Write the files of `plymotion modes`; return them. `shapes` are drawn and animated.

        >>> import plymotion as pm
        >>> files = pm.modes("pendulum.toml", at="equilibrium").write("build/shapes", shapes=1)
        >>> [file.name for file in files]
        ['modes.json', 'linear.npz', 'linear.mat', 'modes.png', 'mode-01.vtkhdf']
        """
        with named(folder):
            names = write_modes(Path(folder), self._found, shapes)
        return [Path(folder) / name for name in names]

    def to_pandas(self) -> Any:
        """Return a DataFrame with a row for each mode. Raises ImportError without pandas.

        >>> import plymotion as pm
        >>> float(pm.modes("pendulum.toml", at="equilibrium").to_pandas()["frequency_hz"][0]) > 0.6
        True
        """
        return pandas().DataFrame(self._found.each)

    def __repr__(self) -> str:
        listed = ", ".join(f"{hertz:.4g}" for hertz in self.frequencies[:5])
        more = ", ..." if len(self.frequencies) > 5 else ""
        where = f"{self.numbers['case']}/{self.numbers['run']} about {self.numbers['state']}"
        return f"<Modes {where}: {listed}{more} Hz>"

    def _repr_html_(self) -> str:
        columns = self.frequencies, self.damping, self.names
        rows = zip(*(list(column) for column in columns), strict=True)
        return table(["Hz", "damping", "main coordinate"], rows, repr(self).strip("<>"))


class Campbell:
    """Frequencies of a run over the speed at which it turns.

    Attributes
    ----------
    numbers : the content of campbell.json: axis, branches, crossings, notes
    speeds : (k,) [rad/s]
    names : of the b branches
    frequencies : (k, b) [Hz], seen from the axes that `numbers["axes"]` names; NaN where a branch
        is unknown
    crossings : with harmonics of the speed: branch, harmonic, speed [rad/s], angular_frequency
    notes : what limits their meaning

    Examples
    --------
    >>> import plymotion as pm
    >>> found = pm.campbell("rotor.toml", [5.0, 10.0, 15.0])
    >>> found.frequencies.shape == (3, len(found.names))
    True
    """

    def __init__(self, diagram: Diagram) -> None:
        self._diagram = diagram
        self.numbers = diagram.content()
        self.speeds, self.names = np.array(diagram.speeds), diagram.names
        rows = [np.array(branch.seen(diagram.fixed), dtype=float) for branch in diagram.branches]
        self.frequencies = np.abs(np.array(rows).T) / (2.0 * np.pi)
        self.crossings: list[dict[str, Any]] = self.numbers["crossings"]
        self.notes = list(diagram.spins.notes)

    def plot(self, axes: Any = None, **style: Any) -> Any:
        """Draw the branches over the speed; return the axes. Needs matplotlib.

        >>> import plymotion as pm
        >>> pm.campbell("rotor.toml", [5.0, 10.0, 15.0]).plot().get_ylabel()
        'frequency [Hz]'
        """
        axes = pyplot().gca() if axes is None else axes
        for name, branch in zip(self.names, self.frequencies.T, strict=True):
            axes.plot(self.speeds, branch, **{"label": name, **style})
        axes.set(xlabel="speed [rad/s]", ylabel="frequency [Hz]")
        return axes

    def write(self, folder: str | Path) -> list[Path]:
        """Write campbell.png, campbell.csv and campbell.json; return them.

        >>> import plymotion as pm
        >>> files = pm.campbell("rotor.toml", [5.0, 10.0, 15.0]).write("build/campbell")
        >>> [file.name for file in files]
        ['campbell.png', 'campbell.csv', 'campbell.json']
        """
        with named(folder):
            return [Path(folder) / name for name in write_campbell(Path(folder), self._diagram)]

    def __repr__(self) -> str:
        case, span = self.numbers["case"], f"{self.speeds[0]:g} to {self.speeds[-1]:g} rad/s"
        return f"<Campbell {case}/{self.numbers['run']}: {len(self.names)} branches, {span}>"

    def _repr_html_(self) -> str:
        rows = [
            [float(w), *map(float, row)]
            for w, row in zip(self.speeds, self.frequencies, strict=True)
        ]
        return table(["rad/s", *self.names], rows, repr(self).strip("<>"))


def modes(
    case: Case | str | Path,
    run: str | None = None,
    *,
    at: str = "start",
    axis: Sequence[float] | None = None,
    packages: str | Path | None = None,
    coarse: bool = False,
) -> Modes:
    """Linearise a run about a state: frequencies, damping, shapes, state space.

    Parameters
    ----------
    case, run, packages, coarse : as for `plymotion.run`
    at : start, equilibrium, t=TIME [s], or spin=SPEED [rad/s] (rpm if it ends in rpm)
    axis : of the spin through the origin, global; None: that of the case or of its hub

    Raises
    ------
    InputError
        A mistake in the case; no such state; a body that cannot be built.

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.modes("pendulum.toml", at="t=2").frequencies
    Traceback (most recent call last):
    plymotion.solver.errors.InputError: --at t=2: expected a time from 0 to solver.t_end = 1 s
    """
    place = at_of(str(at))
    if place.speeds is not None and place.speeds.size > 1:
        raise InputError(f"modes(): at = {at!r}: expected one speed; campbell() takes several")
    return Modes(_states(case, run, packages, coarse=coarse), place, _axis(axis))


def campbell(
    case: Case | str | Path,
    speeds: Sequence[float] | Array,
    run: str | None = None,
    *,
    axis: Sequence[float] | None = None,
    count: int = 20,
    harmonics: int = 4,
    axes: str = "auto",
    packages: str | Path | None = None,
    coarse: bool = False,
) -> Campbell:
    """Follow the modes of a run over the speed at which it turns as a whole.

    Parameters
    ----------
    case, run, packages, coarse : as for `plymotion.run`
    speeds : two or more, rising [rad/s]
    axis : as for `plymotion.modes`
    count : modes that are followed
    harmonics : of the speed, with which crossings are found
    axes : of the frequencies: turning, fixed, or auto (fixed if all modes are whirls)

    Raises
    ------
    InputError
        A mistake in the case; no equilibrium at a speed; a body that cannot be built.

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.campbell("rotor.toml", [10.0, 0.0])
    Traceback (most recent call last):
    plymotion.solver.errors.InputError: campbell(): speeds: expected two or more, rising
    """
    w = np.asarray(speeds, dtype=float)
    if w.ndim != 1 or w.size < 2 or not (np.diff(w) > 0.0).all():
        raise InputError("campbell(): speeds: expected two or more, rising")
    if axes not in ("auto", "turning", "fixed"):
        raise InputError(f"campbell(): axes = {axes!r}: expected auto, turning or fixed")
    spins = Spins(_states(case, run, packages, coarse=coarse), _axis(axis))
    return Campbell(Diagram(spins, w, count, harmonics, axes))


def _states(
    case: Case | str | Path, run: str | None, packages: str | Path | None, *, coarse: bool
) -> States:
    return States(spec_of_run(*chosen(case, run, coarse=coarse), path_of(packages)))


def _axis(axis: Sequence[float] | None) -> Array | None:
    if axis is None:
        return None
    vector = np.asarray(axis, dtype=float)
    if vector.shape != (3,) or not vector.any():
        raise InputError(f"axis = {axis}: expected three numbers, not all zero")
    return vector
