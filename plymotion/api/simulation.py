"""`plymotion.simulate`: a run that a program moves on, step by step."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from ..solver.dynamics.analysis.joint_coordinates import JointCoordinates, Projected
from ..solver.errors import InputError, nearest
from ..solver.math.arrays import Array
from ..solver.mechanism.build import build, used_packages
from ..solver.mechanism.built_mechanism import BuiltMechanism
from ..solver.run.coupled import Kept, Stepper
from ..solver.run.execution import read_run
from .case import Case
from .result import chosen, named, written

Inputs = Mapping[str, float] | Sequence[float] | Array
EVERY = 20  # steps, of which the monitors look at one


class Values(dict[str, float]):
    """Numbers by name; an unknown name is a KeyError that suggests the nearest."""

    def __missing__(self, name: str) -> float:
        raise KeyError(f"no {name!r}{nearest(name, self)}")


class Simulation:
    """A run under way, moved on by `step`; docs/python.md.

    It is the same stepping as that of an FMU: steps of the integrator end at each communication
    point, and inputs may change there. Monitors look at the first step, then at one of 20, sooner
    where these are long.

    Attributes
    ----------
    inputs : names of the drives and forces that `step` writes, in their order

    Examples
    --------
    >>> import plymotion as pm
    >>> sim = pm.simulate("pendulum.toml")
    >>> start = sim.state
    >>> for _ in range(100):
    ...     sim.step(0.001)
    >>> there = sim.signals["tip_z"]
    >>> sim.state = start
    >>> sim.step(0.1)
    >>> abs(sim.signals["tip_z"] - there) < 1e-4
    True
    """

    def __init__(self, stepper: Stepper, built: Any) -> None:
        self._stepper, self._rebuilt = stepper, built
        self.inputs = tuple(given.name for given in stepper.inputs)
        none = np.zeros(0)
        self._read: tuple[Any, tuple[Array, Array]] = None, (none, none)
        self._values = np.array([given.start[0] for given in stepper.inputs])
        self.reset()

    def reset(self, inputs: Inputs | None = None) -> None:
        """Go back to the start of the run at t = 0, with other inputs there.

        >>> import plymotion as pm
        >>> sim = pm.simulate("pendulum.toml")
        >>> sim.step(0.01)
        >>> sim.reset()
        >>> sim.t
        0.0
        """
        self._take(inputs)
        self._stepper.start(self._values.copy(), force_order=0)

    def step(self, dt: float, inputs: Inputs | None = None) -> None:
        """Move on by dt [s].

        Parameters
        ----------
        inputs : by name, or all in the order of `inputs`; those that are not given keep their
            values. Forces and torques [N, N m] are constant over the step, drives [rad, m] go
            smoothly on from their last values

        Raises
        ------
        InputError
            An unknown input; a run that cannot go on.

        >>> import plymotion as pm
        >>> sim = pm.simulate("pendulum.toml")
        >>> sim.step(0.001)
        >>> sim.t
        0.001
        """
        _require_time("step(", dt)
        if inputs is not None:
            self._take(inputs)
        self._stepper.move(self._stepper.t + dt, self._values)

    def _take(self, inputs: Inputs | None) -> None:
        values = self._values.copy()
        if isinstance(inputs, Mapping):
            for name, value in inputs.items():
                if name not in self.inputs:
                    raise InputError(f"no input {name!r}{nearest(name, self.inputs)}")
                found = _numbers(name, value)
                if len(found) != 1:
                    raise InputError(f"{name}: {len(found)} values; expected 1")
                values[self.inputs.index(name)] = found[0]
        elif inputs is not None:
            values = _numbers("inputs", inputs)
            if len(values) != len(self.inputs):
                raise InputError(
                    f"inputs: {len(values)} values; expected {len(self.inputs)}, in the order "
                    f"{', '.join(self.inputs)}"
                )
        self._values = values

    @property
    def t(self) -> float:
        """Time [s].

        >>> import plymotion as pm
        >>> pm.simulate("pendulum.toml").t
        0.0
        """
        return float(self._stepper.t)

    @property
    def state(self) -> tuple[Kept, Array]:
        """All that the steps to come depend on; set it to go on from there, equal to the last bit.

        >>> import plymotion as pm
        >>> sim = pm.simulate("pendulum.toml")
        >>> start = sim.state
        >>> sim.step(0.01)
        >>> sim.state = start
        >>> sim.t
        0.0
        """
        return self._stepper.kept(), self._values.copy()

    @state.setter
    def state(self, state: tuple[Kept, Array]) -> None:
        kept, values = (
            state if isinstance(state, tuple) and len(state) == 2 else (None, self._values)
        )
        self._stepper.restore(kept)
        self._values = values.copy()

    @property
    def y(self) -> Array:
        """State (n,) of the mechanism: positions, velocities, auxiliary states, work.

        >>> import plymotion as pm
        >>> pm.simulate("pendulum.toml").y.shape
        (14,)
        """
        return self._stepper.y.copy()

    @property
    def signals(self) -> Values:
        """Signals of the case at the present time. Angles count turns if they are read in each.

        >>> import plymotion as pm
        >>> pm.simulate("pendulum.toml").signals["tip_x"]
        1.0
        """
        return Values(zip(self._stepper.outputs, self._stepper.measured().tolist(), strict=True))

    @property
    def warnings(self) -> list[str]:
        """What the monitors have found since the last look.

        >>> import plymotion as pm
        >>> pm.simulate("pendulum.toml").warnings
        []
        """
        return self._stepper.warnings()

    @cached_property
    def _built(self) -> tuple[JointCoordinates, BuiltMechanism]:
        built: BuiltMechanism = self._rebuilt()
        offsets = {name: joint.shift for name, joint in built.joints.items()}
        names = built.body_names, built.joint_names
        return JointCoordinates(built.model, *names, offsets), built

    @property
    def _joints(self) -> JointCoordinates:
        """The joint coordinates, with the laws of time of the run, which inputs change."""
        joints, built = self._built
        now, model = self._stepper.prepared.model, built.model
        model.law_time[:], model.law_coefficient[:] = now.law_time, now.law_coefficient
        model.quantities.law[:] = now.quantities.law
        return joints

    @property
    def coordinates(self) -> list[str]:
        """Names of the joint coordinates of a tree, in the order of `q`.

        "JOINT.angle", "JOINT.z", "BODY.q1" of a mode.

        >>> import plymotion as pm
        >>> pm.simulate("pendulum.toml").coordinates
        ['hinge.angle']
        """
        return list(self._joints.names)

    @property
    def q(self) -> Array:
        """Joint coordinates (n,); angles within half a turn [rad, m].

        >>> import plymotion as pm
        >>> pm.simulate("pendulum.toml").q
        array([0.])
        """
        return self._values_now()[0]

    def _values_now(self) -> tuple[Array, Array]:
        y = self._stepper.y
        if self._read[0] is not y:
            self._read = y, self._joints.values(y)
        return self._read[1]

    @property
    def qd(self) -> Array:
        """Rates (n,) of the joint coordinates [rad/s, m/s].

        >>> import plymotion as pm
        >>> pm.simulate("pendulum.toml").qd
        array([0.])
        """
        return self._values_now()[1]

    def place(self, q: Sequence[float] | Array, qd: Sequence[float] | Array | None = None) -> None:
        """Start at t = 0 from joint coordinates and rates (n,); modes that are not given are 0.

        Angles may have any number of turns: stops, springs and controllers count from there.

        Raises
        ------
        InputError
            Drives at the present inputs, or couplings, do not allow these coordinates.

        >>> import plymotion as pm
        >>> sim = pm.simulate("pendulum.toml")
        >>> sim.place([0.5])
        >>> sim.q.round(12)
        array([0.5])
        """
        joints = self._joints
        n = len(joints.names)
        given = [np.zeros(n), np.zeros(n)]
        for whole, part in zip(given, (q, [] if qd is None else qd), strict=True):
            values = _numbers("place", part)
            if len(values) > n:
                raise InputError(f"place: {len(values)} values; expected at most {n}")
            whole[: len(values)] = values
        self._stepper.place(joints.state(0.0, self._stepper.y, *given), self._values)

    def equations(self) -> Projected:
        """Return M (n, n), c (n,) and Z (n_vel, n) of M qdd + c = tau at the present state.

        c has velocity terms, elastic forces and all forces of the case, less weight; tau are
        forces of drives. Couplings are left out.

        >>> import plymotion as pm
        >>> pm.simulate("pendulum.toml").equations().c.round(3)
        array([-9.81])
        """
        return self._joints.projected(self.t, self._stepper.y)

    def mass_matrix(self) -> Array:
        """Return the mass matrix (n, n) in the joint coordinates.

        >>> import plymotion as pm
        >>> pm.simulate("pendulum.toml").mass_matrix().round(3)
        array([[0.67]])
        """
        return self.equations().M

    def jacobian(self, at: str) -> Array:
        """Return velocity and angular velocity of a place by the rates of the joint coordinates.

        Parameters
        ----------
        at : "BODY.INTERFACE"

        Returns
        -------
        (6, n), global components [m/s, rad/s]

        >>> import plymotion as pm
        >>> pm.simulate("pendulum.toml").jacobian("rod.tip").round(12).T
        array([[ 0.,  0., -1.,  0.,  1.,  0.]])
        """
        known = self._built[1].markers
        if at not in known:
            raise InputError(f"no place {at!r}{nearest(at, known)}")
        return self._joints.jacobian(self.t, self._stepper.y, known[at])

    def __repr__(self) -> str:
        return f"<Simulation at t = {self.t:.6g} s: {len(self.inputs)} inputs>"


def _require_time(call: str, value: Any) -> None:
    if not (isinstance(value, Real) and 0.0 < float(value) < np.inf):
        raise InputError(f"{call}{value!r}): expected a time above 0 [s]")


def _numbers(what: str, values: object) -> Array:
    """Return finite numbers of the caller (k,), in a new array."""
    try:
        found = np.atleast_1d(np.asarray(values))
    except ValueError:  # lists of different lengths
        found = np.zeros((0, 0))
    if found.ndim != 1 or found.dtype.kind not in "iuf" or not np.isfinite(found).all():
        raise InputError(f"{what} = {values!r}: expected finite numbers")
    return found.astype(float)


def simulate(
    case: Case | str | Path,
    run: str | None = None,
    *,
    inputs: Sequence[str] | None = None,
    fixed_step: float | None = None,
    out: str | Path | None = None,
    packages: str | Path | None = None,
) -> Simulation:
    """Return a run that steps under the control of the caller; docs/python.md.

    Packages of flexible bodies are built where they are missing, as by `pm.run`.

    Vibrations of flexible bodies that the ends of steps cannot show, above pi / dt [rad/s], are
    accurate to `rtol` in displacements, not in rates. A step of 1 ms of a robot with two flexible
    links then takes an eighth of the time. `cutoff_frequency = 0` in `[solver]` of the case
    resolves rates, too.

    Parameters
    ----------
    case : a case, or its file
    run : name of the run; absent: the only one
    inputs : drives and forces that `step` writes, such as "joints.hinge.drive" and "forces.motor";
        absent: all. The others follow their laws in the case
    fixed_step : step of the integrator [s], without error control, for a known price of each step;
        docs/python.md has its accuracy. Absent: by `rtol` of the case
    out : folder of the case; absent: build/NAME
    packages : folder of ready packages: FEniCSx is not needed

    Raises
    ------
    InputError
        A mistake in the case; an integrator that cannot restart: expected radau, rk8 or rk5.

    Examples
    --------
    >>> import plymotion as pm
    >>> sim = pm.simulate("pendulum.toml")
    >>> sim.step(0.01)
    >>> sim
    <Simulation at t = 0.01 s: 0 inputs>
    """
    if fixed_step is not None:
        _require_time("simulate(fixed_step=", fixed_step)
    checked, run, folder = chosen(case, run, out)
    with named(out):
        spec = read_run(written(checked, folder, f"runs/{run}.json", packages))
    stepper = Stepper(spec, inputs, every=EVERY, fixed_step=fixed_step, sparing=True)

    def built() -> BuiltMechanism:
        used = used_packages(spec.mechanism, spec.packages)
        return build(spec.mechanism, used, everywhere=True)

    return Simulation(stepper, built)
