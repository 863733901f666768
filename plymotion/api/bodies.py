"""Shells and solids in Python, and modal packages: what they have, from and to other codes."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..solver.errors import InputError
from ..solver.extras.exchange import export_body
from ..solver.extras.exchange import import_body as import_from
from ..solver.inputs.shell_specification import load_shell
from ..solver.inputs.solid_specification import solid_spec
from ..solver.math.arrays import Array
from ..solver.package import ModalPackage, Remark, read_package
from ..solver.package import validate as findings_of
from ..solver.package.body.lay_ups import LayUp
from ..solver.package.shell.shell_schema import ShellFile
from ..solver.report.shell.findings import read_shown, shell_json
from ..solver.report.solid import solid_table
from ..solver.studies.cases import folder_lock
from ..solver.studies.fmu import VERSIONS
from ..solver.workers.description_results import Entry, SpecOf, made_file
from ..solver.workers.packages import prepared
from .case import ByName, Case
from .result import chosen, named, path_of
from .signal import table


class _Analysed:
    """What shells and solids share: a file, and its numbers by name.

    Attributes
    ----------
    file : path of the results file
    numbers : what `plymotion shell --json` or `solid --json` prints, SI
    """

    def __init__(self, file: Path, numbers: dict[str, Any]) -> None:
        self.file, self.numbers = file, numbers

    @property
    def name(self) -> str:
        """Name of the part."""
        return str(self.numbers["name"])

    @property
    def cases(self) -> ByName[dict[str, Any]]:
        """Numbers of the load cases, by name."""
        return ByName("load cases", self.numbers.get("cases", {}))

    @property
    def warnings(self) -> list[dict[str, str]]:
        """Warnings with `code` and `message` (docs/warnings.md)."""
        return list(self.numbers["warnings"])

    def __repr__(self) -> str:
        parts = [f"{hertz:.4g} Hz" for hertz in self.frequencies[:1]]
        parts += [f"load case {name}" for name in self.cases]
        return f"<{type(self).__name__} {self.name}: {', '.join(parts) or 'no load cases'}>"

    def _repr_html_(self) -> str:
        shown = [(k, v) for k, v in self.numbers.items() if not isinstance(v, dict | list)]
        return table(["", ""], shown, repr(self).strip("<>"))

    @property
    def frequencies(self) -> Array:
        """Natural frequencies (k,) [Hz]."""
        raise NotImplementedError


class Shell(_Analysed):
    """An analysed plate or shell; docs/shells.md.

    Attributes
    ----------
    file : path of the shell file
    numbers : what `plymotion shell --json` prints, SI
    cases : numbers of the load cases by name
    name, warnings : text; dicts with `code` and `message`

    Examples
    --------
    >>> import plymotion as pm
    >>> shell = pm.Shell("plate.vtkhdf")
    >>> shell.cases["bending"]["deflection"]["largest"] > 0.0
    True
    """

    def __init__(self, file: str | Path) -> None:
        self.data: ShellFile
        self.data, numbers = read_shown(Path(file), shell_json)
        super().__init__(Path(file), numbers)

    @property
    def frequencies(self) -> Array:
        """Natural frequencies (k,) [Hz], without motions that have no strain energy.

        >>> import plymotion as pm
        >>> pm.Shell("plate.vtkhdf").frequencies
        array([ 7.95774715, 19.09859317])
        """
        return np.array(self.numbers["frequencies_hz"] or [])

    @property
    def load_factors(self) -> dict[str, Array]:
        """Load factors of buckling (k,) by load case; empty if they were not asked for.

        >>> import plymotion as pm
        >>> pm.Shell("plate.vtkhdf").load_factors["bending"]
        array([2.5, 7. ])
        """
        cases = self.numbers.get("load_factors", {})
        return {name: np.array(case["factors"]) for name, case in cases.items()}


class Solid(_Analysed):
    """An analysed part from CAD; docs/solids.md. Its file is a package for a case.

    Attributes
    ----------
    file : path of the modal package
    numbers : what `plymotion solid --json` prints, SI
    cases : numbers of the load cases by name
    name, warnings : text; dicts with `code` and `message`

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.Solid("bracket.vtkhdf")
    <Solid bracket: 812.5 Hz>
    """

    def __init__(self, file: str | Path) -> None:
        super().__init__(Path(file), solid_table(Path(file)))

    @property
    def mass(self) -> float:
        """Mass [kg].

        >>> import plymotion as pm
        >>> pm.Solid("bracket.vtkhdf").mass
        2.4
        """
        return float(self.numbers["mass"])

    @property
    def frequencies(self) -> Array:
        """Natural frequencies (k,) of the free part [Hz].

        >>> import plymotion as pm
        >>> pm.Solid("bracket.vtkhdf").frequencies
        array([ 812.5, 1630. ])
        """
        return np.array(self.numbers["free_hz"])


class Package:
    """A modal package: what `plymotion info` shows.

    Attributes
    ----------
    file : path of the package

    Examples
    --------
    >>> import plymotion as pm
    >>> package = pm.info("rod.vtkhdf")
    >>> package.name, package.mass > 0.0, len(package.frequencies) == len(package.labels)
    ('rod', True, True)
    """

    def __init__(self, file: str | Path) -> None:
        self.file = Path(file)
        self.data: ModalPackage = read_package(self.file)

    @property
    def name(self) -> str:
        """Name of the body.

        >>> import plymotion as pm
        >>> pm.info("rod.vtkhdf").name
        'rod'
        """
        return self.data.body

    @property
    def mass(self) -> float:
        """Mass [kg].

        >>> import plymotion as pm
        >>> pm.info("rod.vtkhdf").mass > 0.0
        True
        """
        return float(self.data.invariants.mass)

    @property
    def frequencies(self) -> Array:
        """Frequencies (m,) of the modes [Hz].

        >>> import plymotion as pm
        >>> bool(pm.info("rod.vtkhdf").frequencies.min() > 0.0)
        True
        """
        return np.asarray(self.data.frequencies / (2.0 * np.pi))

    @property
    def labels(self) -> list[str]:
        """Names of the modes, m words.

        >>> import plymotion as pm
        >>> len(pm.info("rod.vtkhdf").labels) == pm.info("rod.vtkhdf").data.n_mode
        True
        """
        return list(self.data.mode_labels or self.data.mode_kinds)

    @cached_property
    def interfaces(self) -> dict[str, Array]:
        """Positions (3,) of the interfaces in the body frame [m], by name.

        >>> import plymotion as pm
        >>> pm.info("rod.vtkhdf").interfaces["root"].shape
        (3,)
        """
        return {place.name: place.position_B for place in self.data.interfaces}

    def lay_up(self, laminate: str | None = None) -> LayUp:
        """Modal stiffness of a shell with other angles and thicknesses of its plies.

        `lay_up().stiffness(angles_deg)` is exact for the modes of the package (docs/design.md).

        Parameters
        ----------
        laminate : name; None for the only one

        Raises
        ------
        PackageError
            No such laminate; a package without `stiffness_rates` of it.

        Examples
        --------
        >>> import plymotion as pm
        >>> pm.info("rod.vtkhdf").lay_up("skin")
        Traceback (most recent call last):
        plymotion.solver.errors.PackageError: rod: laminate 'skin': expected one of none
        """
        return LayUp(self.data, laminate)

    def __repr__(self) -> str:
        return f"<Package {self.name}: {self.data.n_mode} modes, {self.mass:.4g} kg>"

    def _repr_html_(self) -> str:
        rows = zip(self.labels, map(float, self.frequencies), strict=True)
        return table(["mode", "Hz"], rows, repr(self).strip("<>"))


def shell(
    file: str | Path,
    *,
    buckling: int | None = None,
    bound: str | None = None,
    out: str | Path = "build/shells",
    force: bool = False,
) -> Shell:
    """Return the shell of a description (TOML), analysed unless that is up to date, or of a shell
    file (.vtkhdf), which needs no FEniCSx.

    Parameters
    ----------
    buckling : number of load factors of each load case
    bound : "frequency", "buckling" or "compliance": its bound over all angles of the plies
    out : folder of shell files
    force : analyse what is up to date

    Raises
    ------
    InputError
        A mistake in the description, one line each; an analysis that fails.
    PackageError
        Not a shell file.

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.shell("plate.vtkhdf").name
    'plate'
    """
    made = _analysed(
        Path(file), "shell", lambda e: load_shell(e.file, buckling, bound), out, force=force
    )
    return Shell(made)


def solid(
    file: str | Path,
    *,
    material: str | None = None,
    size: float | None = None,
    out: str | Path = "build/solids",
    force: bool = False,
) -> Solid:
    """Return the solid of a CAD file or a description (TOML), analysed unless that is up to date,
    or of a package (.vtkhdf) that was made so, which needs no FEniCSx.

    Parameters
    ----------
    material : of a CAD file: a metal, or "E,nu,rho" in SI
    size : of the cells [m]
    out : folder of the packages
    force : analyse what is up to date

    Raises
    ------
    InputError
        A mistake in the description, one line each; an analysis that fails.

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.solid("bracket.step", size=-1.0)
    Traceback (most recent call last):
    plymotion.solver.errors.InputError: size = -1: expected a length above 0
    """
    if size is not None and not size > 0.0:
        raise InputError(f"size = {size:g}: expected a length above 0")
    made = _analysed(
        Path(file), "solid", lambda e: solid_spec(e.file, material, size), out, force=force
    )
    return Solid(made)


def _analysed(file: Path, command: str, spec_of: SpecOf, out: str | Path, *, force: bool) -> Path:
    """Return the results file of a description; a results file as it is."""
    if file.suffix == ".vtkhdf":
        return file
    with named(out):
        return made_file(Entry(file.stem, file), command, spec_of, Path(out), force=force)


def info(package: str | Path) -> Package:
    """Return what a modal package has: modes, mass, interfaces.

    Raises PackageError if it is none.

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.info("rod.vtkhdf").interfaces.keys() >= {"root", "tip"}
    True
    """
    return Package(package)


def validate(file: str | Path) -> list[Remark]:
    """Return what is wrong or doubtful in a modal package or a section file (docs/format.md).

    Each remark has `level` (error, warning, note), `dataset` and `message`. The file can be used
    if none is an error.

    Examples
    --------
    >>> import plymotion as pm
    >>> [remark for remark in pm.validate("rod.vtkhdf") if remark.level == "error"]
    []
    """
    return findings_of(file)


def import_body(file: str | Path, out: str | Path, *, source: str | None = None) -> Package:
    """Make a modal package from a body of another code (docs/exchange.md).

    Parameters
    ----------
    file : names the files of the other code, their units, the interfaces and the modes (TOML)
    out : the package, PACKAGE.vtkhdf
    source : the other code; None: the key `from` of the file

    Raises
    ------
    InputError
        A mistake in a file, as `plymotion import` reports it.

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.import_body("nothing.toml", "body.vtkhdf")
    Traceback (most recent call last):
    plymotion.solver.errors.InputError: nothing.toml: no such file...
    """
    with named(out):
        _refused(*import_from(Path(file), Path(out), source, quiet=True, show=False))
    return Package(out)


def export(
    what: Case | str | Path,
    to: str,
    out: str | Path,
    *,
    run: str | None = None,
    inputs: Sequence[str] | None = None,
    packages: str | Path | None = None,
    coarse: bool = False,
) -> Path:
    """Write a modal package in the format of another code, or a run of a case as an FMU.

    Parameters
    ----------
    what : a modal package; with `to="fmu"` or `"fmu3"` a case, or its file
    to : exudyn, mujoco, uff, med, dmig, mbdyn, sid, or fmu (FMI 2.0), fmu3 (FMI 3.0)
    out : the new file, which is returned
    run, inputs, packages, coarse : of an FMU: the run, names of the drives and forces that are its
        inputs (None: all); others as for `plymotion.run`

    Raises
    ------
    InputError
        A package or a case that is wrong; no C compiler (FMU).

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.export("rod.vtkhdf", "sid", "rod.SID_FEM").name
    'rod.SID_FEM'
    """
    if to not in VERSIONS:
        of_fmu: Mapping[str, Any] = {"run": run, "inputs": inputs, "packages": packages}
        for key in (key for key, value in of_fmu.items() if value is not None):
            raise InputError(f'export(): {key}: expected with to="fmu" or "fmu3" only')
        if isinstance(what, Case):
            raise InputError(f'export(): {what!r}: expected a modal package, or to="fmu", "fmu3"')
        with named(out):
            _refused(*export_body(Path(what), to, Path(out), show=False))
        return Path(out)
    from ..solver.studies.fmu.write import write_fmu

    checked, run, folder = chosen(what, run, coarse=coarse)
    with named(out), folder_lock(folder):
        file = prepared(checked, folder, f"runs/{run}.json", path_of(packages))
        write_fmu(file, Path(out), inputs, to)
    return Path(out)


def _refused(code: int, text: str) -> None:
    """Raise InputError with the messages of an exchange that failed."""
    if code:
        lines = [line for line in text.splitlines() if line.startswith("error: ")]
        raise InputError("\n".join(line.removeprefix("error: ") for line in lines) or text.strip())
