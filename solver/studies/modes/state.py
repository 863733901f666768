"""The run that `plymotion modes` works on, and the states that `--at` names."""

import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...dynamics.model.coordinates import Spin
from ...dynamics.model.model import Model
from ...errors import InputError, PackageError
from ...inputs.case.record import case_file
from ...math.arrays import Array
from ...mechanism.build import build
from ...mechanism.built_mechanism import BuiltMechanism, Start
from ...mechanism.consistent import consistent_state
from ...mechanism.equilibrium import (
    given_spin,
    hub_axis,
    relative_equilibrium,
    resting_state,
    spin_about,
)
from ...mechanism.start import starting_state
from ...run.execution import read_run
from ...run.inputs import RunSpec
from ...run.preparation import complete, prepare
from ..cases import build_folder, chosen_run
from ..linearisation.state_space import common_spin
from .place import At

if TYPE_CHECKING:
    from ...inputs.case.design import Case

# The run of a case, with packages built if out of date.


def read_spec(
    file: Path, run: str | None, *, packages: Path | None, coarse: bool
) -> tuple[RunSpec, Path]:
    """Return a run with its packages, and the folder build/<case> of its results.

    Parameters
    ----------
    file : cases/<name>/case.toml, or a run file build/<case>/runs/<run>.json
    run : name of the run; None: the only one, or the first
    packages : folder of ready packages; None: build/<case>/bodies, built there if out of date

    Raises
    ------
    InputError, PackageError
        An unknown run; what `check` and `run` find; packages that cannot be built.
    """
    if file.suffix == ".json":
        spec = read_run(file)
        if run is not None and run != spec.run:
            raise InputError(f"--run {run}: {file} is run {spec.run}; expected a case file")
        return spec, file.parent.parent
    from ...inputs.case.load import load_case  # 0.2 s, which a run file does without

    file = case_file(file)
    case = load_case(file, coarse=coarse, sweeps=())
    build = build_folder(file, coarse=coarse)
    try:
        return spec_of_run(case, chosen_run(case, run), build, packages), build
    except PackageError as error:
        raise PackageError(f"{error}; `plymotion {file}` builds the packages") from None


def spec_of_run(case: "Case", name: str, build: Path, packages: Path | None) -> RunSpec:
    """Return a run of a checked case with its packages, built into build/bodies if out of date.

    The run file of the folder stays as it is. Raises as `read_spec`.

    Parameters
    ----------
    case : checked case
    name : name of the run
    build : folder of the results of the case
    packages : folder of packages that are ready; None: they are built
    """
    from ...inputs.case.write import write_case
    from ...workers.packages import build_packages, specs_of

    with tempfile.TemporaryDirectory(prefix="plymotion-") as temporary:
        out = Path(temporary)
        write_case(case, out, packages or build / "bodies")
        if packages is None:
            specs = specs_of(out, [name])
            build_packages(specs, build / "bodies")
        return read_run(out / "runs" / f"{name}.json")


# The states that `--at` names, other than a range of speeds.


@dataclass(frozen=True)
class State:
    """A state about which the equations are linearised."""

    model: Model  # with the laws of time that hold there
    t: float  # [s]
    y: Array  # (n,)
    spin: Spin | None  # at which the whole mechanism turns
    words: str  # for titles
    given_spin: bool = False  # asked for by its spin


class States:
    """States of a run."""

    def __init__(self, spec: RunSpec) -> None:
        self.spec = spec
        try:
            self.built: BuiltMechanism = build(spec.mechanism, spec.packages)
        except InputError as error:
            raise InputError(f"{spec.case}, run {spec.run}: {error}") from error

    @cached_property
    def tables(self) -> Model | None:
        """The model with all bodies of second order; None: they are, or have no such data."""
        packages, mechanism = self.spec.packages, self.spec.mechanism
        known = any(package.second_order is not None for package in packages.values())
        if mechanism.solver.geometric_stiffening or not known:
            return None
        return build(mechanism, packages, stiffening=True).model

    def at(self, at: At, axis: Array | None) -> State:
        """Return the state of `--at`; `axis` (3,) is that of the command line.

        Raises
        ------
        InputError
            A time outside the run, no equilibrium, no axis of a spin.
        """
        if at.kind == "spin" and at.speeds is not None:
            spin = self.spin(axis)._replace(rate=float(at.speeds[0]))
            return self.turning(spin, self.start())
        if at.kind == "time" and at.time:
            return self._later(at.time)
        built, solver = self.built, self.spec.mechanism.solver
        names = built.joint_names, built.body_names
        given = given_spin(solver)
        if at.kind == "equilibrium" and given is not None and given.rate != 0.0:
            return self.turning(given, self.start())
        if at.kind == "equilibrium":
            model, y = resting_state(built.model, self.start(), built.body_names)
            return State(model, 0.0, y, None, "equilibrium")
        y = starting_state(built.model, built.start, solver.start, *names, given, built.light)
        return self._moving(0.0, y, "start")

    def start(self) -> Start:
        """Return the start of the case with its joints closed."""
        built = self.built
        n = built.model.n_vel
        free = Start(built.start.positions, np.zeros(n), np.zeros(n, dtype=bool))
        y = consistent_state(built.model, free, built.joint_names)
        return Start(y[: built.model.n_pos], free.velocities, free.given)

    def spin(self, axis: Array | None) -> Spin:
        """Return the axis of a spin, at speed zero: of the command line, the case or the hub."""
        given = given_spin(self.spec.mechanism.solver)
        if axis is not None:
            point = given.point if given is not None else np.zeros(3)
            return spin_about(axis, point, 0.0)
        if given is not None:
            return given._replace(rate=0.0)
        return spin_about(*hub_axis(self.built), 0.0)

    def turning(self, spin: Spin, start: Start) -> State:
        """Return the relative equilibrium at a spin near a start. Raises InputError."""
        built = self.built
        if spin.rate == 0.0:
            model, y = resting_state(built.model, start, built.body_names)
            return State(model, 0.0, y, spin, "rest")
        names = built.joint_names, built.body_names
        equilibrium = relative_equilibrium(built.model, start, spin, *names)
        return State(
            equilibrium.model,
            0.0,
            equilibrium.y,
            spin,
            f"spin {spin.rate:g} rad/s",
            given_spin=True,
        )

    def _later(self, t: float) -> State:
        """Integrate the run up to t."""
        end = self.spec.mechanism.solver.t_end
        if not 0.0 < t <= end * (1.0 + 1e-9):
            raise InputError(f"--at t={t:g}: expected a time from 0 to solver.t_end = {end:g} s")
        spec = self.spec.changed({"solver.t_end": t, "solver.output_step": t})
        finished = complete(prepare(spec.mechanism, spec.packages, ()))
        solution = finished.solution
        if solution.status != "finished":
            raise InputError(
                f"--at t={t:g}: the run ended at {solution.t[-1]:.4g} s: {solution.message}"
            )
        return self._moving(t, solution.y[-1], f"t = {t:g} s")

    def _moving(self, t: float, y: Array, label: str) -> State:
        return State(self.built.model, t, y, common_spin(self.built.model, t, y), label)
