"""A case in Python: from a file, or built table by table."""

import re
from collections.abc import Collection, Iterator, Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any, Generic, TypeVar

from ..solver.errors import InputError, counted, nearest
from ..solver.inputs.case.design import Case as CheckedCase
from ..solver.inputs.case.load import checked_case
from ..solver.inputs.case.record import case_file, case_name
from ..solver.inputs.case.tables.schema import split_key
from ..solver.inputs.common.text_file import read_toml
from ..solver.package.common.plain_data import plain
from .builders import Builders
from .keys import Keys, Tables, check, kind_of, model_of, raw
from .signal import table

T = TypeVar("T")


class UnknownName(KeyError, InputError):
    """A name that does not exist; the message has the nearest one that does."""

    def __str__(self) -> str:
        return str(self.args[0])


class ByName(Mapping[str, T], Generic[T]):
    """A mapping that cannot be changed; an unknown name is a KeyError with a suggestion.

    Parameters
    ----------
    what : word for messages: "signals"
    items : in order

    Examples
    --------
    >>> import plymotion as pm
    >>> signals = pm.run("pendulum.toml").signals
    >>> list(signals), "tip_x" in signals
    (['angle', 'tip_x', 'tip_z'], True)
    """

    def __init__(self, what: str, items: Mapping[str, T]) -> None:
        self._what, self._items = what, dict(items)

    def __getitem__(self, name: str) -> T:
        try:
            return self._items[name]
        except KeyError:
            hint = nearest(str(name), self._items)
            raise UnknownName(f"no {name!r} among the {self._what}{hint}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def __repr__(self) -> str:
        return f"<{len(self)} {self._what}: {', '.join(self)}>"

    def _repr_html_(self) -> str:
        return table([self._what, ""], [[name, repr(item)] for name, item in self.items()])


COUNTED = ("bodies", "joints", "forces", "signals", "runs", "sweeps")


class _Entry:
    """A key of the case file that a case may lack; None then. It is checked when it is set."""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, case: "Case | None", owner: type) -> Any:
        if case is None:
            return self
        value = case.table.get(self.name)
        return self._keys(case) if isinstance(value, dict) else value

    def __set__(self, case: "Case", value: Any) -> None:
        value = raw(value)
        if value is not None:
            check(None, model_of(self.name), {self.name: value}, self.name, "", case.folder)
        case.table[self.name] = value

    def _keys(self, case: "Case") -> Keys:
        return Keys(kind_of(self.name), self.name, self.name, case.table, case.folder)


class _Group(_Entry):
    """A table of the case file, by items and attributes."""

    def __get__(self, case: "Case | None", owner: type) -> Any:
        return self if case is None else self._keys(case)


class Case(Builders):
    """A mechanism with its runs and sweeps: what a case file has, in Python.

    Every key of the case file is an attribute of the same name, at every depth:
    `case.solver.rtol = 1e-4`. docs/case-reference.md lists what they hold. Arrays and tuples may
    stand for lists. A wrong value of an attribute is an InputError at once; `check`, `run` and
    `sweep` check the whole case. There are no other attributes: a misspelt one is an
    AttributeError.

    Parameters
    ----------
    name : of the folder of its results
    title : one line
    keys : more keys and tables of the case file: gravity=[0, 0, -9.81], solver={...}

    Attributes
    ----------
    name : text
    folder : path where relative paths of the case start
    table : the content of the case file

    Examples
    --------
    A ball that falls for one second:

    >>> import plymotion as pm
    >>> case = pm.Case("ball", gravity=[0, 0, -9.81], solver={"t_end": 1.0, "output_step": 0.1})
    >>> case.bodies["ball"] = {
    ...     "kind": "rigid", "mass": 2.0, "inertia": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    ...     "interfaces": {"centre": {"position": (0, 0, 0)}},
    ... }
    >>> case.signals["z"] = {"kind": "position", "at": "ball.centre", "component": "z"}
    >>> case
    <Case ball: 1 body, 1 signal, 1 run>
    >>> round(pm.run(case).signals["z"].final, 6)
    -4.905
    """

    __slots__ = ("_file", "folder", "name", "table")

    format = _Entry()
    units = _Entry()
    title = _Entry()
    gravity = _Entry()
    allow = _Entry()
    fidelity = _Entry()
    rotor = _Entry()
    design = _Entry()
    materials = _Group()
    sections = _Group()
    bodies = _Group()
    ground = _Group()
    joints = _Group()
    couplings = _Group()
    forces = _Group()
    parameters = _Group()
    tables = _Group()
    states = _Group()
    masses = _Group()
    signals = _Group()
    solver = _Group()
    variants = _Group()
    coarse = _Group()
    runs = _Group()
    figures = _Group()
    sweeps = _Group()

    def __init__(self, name: str = "case", *, title: str = "", **keys: Any) -> None:
        if not (isinstance(name, str) and re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]*", name)):
            raise InputError(f"Case({name!r}): expected a name of letters, digits and _ . -")
        self.name, self.folder = name, Path()
        self.table: Tables = {"format": 1, "title": title or name, "runs": {"base": {}}, **keys}
        self._file: Path | None = None

    @classmethod
    def _from_file(cls, file: Path) -> "Case":
        case = cls.__new__(cls)
        case.table = read_toml(file, "case file")
        case.name = case_name(file)
        case.folder, case._file = file.parent, file
        return case

    def check(self, *, coarse: bool = False, sweeps: Collection[str] | None = None) -> CheckedCase:
        """Check the whole case as `plymotion check` does; return its checked form.

        Parameters
        ----------
        coarse : the coarse version of the case
        sweeps : names of the sweeps whose members are made and checked; None: all

        Raises
        ------
        InputError
            One line per mistake: key, value, expectation.

        >>> import plymotion as pm
        >>> case = pm.load("pendulum.toml")
        >>> case.bodies["rod"]["mass"] = -1
        >>> case.check()
        Traceback (most recent call last):
        plymotion.solver.errors.InputError: pendulum.toml: bodies.rod.mass = -1: value should be \
greater than or equal to 0
        """
        return checked_case(plain(self.table), self._path, coarse=coarse, sweeps=sweeps)

    @property
    def _path(self) -> Path:
        """Its file; for messages of a case without one, its name in the folder."""
        return self.folder / self.name if self._file is None else self._file

    def changed(self, changes: Tables) -> "Case":
        """Return a copy with other values at dotted keys; positions of lists count from 0.

        >>> import plymotion as pm
        >>> longer = pm.load("pendulum.toml").changed({"solver.t_end": 2.0, "gravity.2": -1.62})
        >>> longer.solver["t_end"], longer.table["gravity"]
        (2.0, [0.0, 0.0, -1.62])
        """
        case = deepcopy(self)
        for key, value in changes.items():
            here: Any = case.table
            *way, last = split_key(key)
            try:
                for part in way:
                    here = here[int(part)] if isinstance(here, list) else here.setdefault(part, {})
                here[int(last) if isinstance(here, list) else last] = value
            except (AttributeError, IndexError, TypeError, ValueError):
                raise InputError(f"{key}: the case has no such key") from None
        return case

    def __repr__(self) -> str:
        counts = {group: len(self.table.get(group, {})) for group in COUNTED}
        parts = [counted(n, _singular(group), group) for group, n in counts.items() if n]
        return f"<Case {self.name}: {', '.join(parts)}>"

    def _repr_html_(self) -> str:
        rows = [
            [group, name, _words(entry)]
            for group in COUNTED
            for name, entry in self.table.get(group, {}).items()
        ]
        title = f"{self.name}: {self.table.get('title', '')}"
        return table(["", "name", ""], rows, title)


def load(file: str | Path, *, coarse: bool = False) -> Case:
    """Read and check a case file.

    Parameters
    ----------
    file : a case file, or a folder with case.toml
    coarse : check its `[coarse]` variant only

    Raises
    ------
    InputError
        One line per mistake: file, key, value, expectation.

    Examples
    --------
    >>> import plymotion as pm
    >>> case = pm.load("pendulum.toml")
    >>> case
    <Case pendulum: 1 body, 1 joint, 3 signals, 1 run>
    >>> case.bodies["rod"]["mass"]
    2.0
    """
    case = as_case(file)
    case.check(coarse=coarse)
    return case


def as_case(case: "Case | str | Path") -> Case:
    """Return a case, or read it from its file; it is not checked."""
    if isinstance(case, Case):
        return case
    if not isinstance(case, str | Path):
        raise InputError(f"{case!r}: expected a Case, or the path of a case file")
    return Case._from_file(case_file(Path(case)))


def _singular(group: str) -> str:
    return "body" if group == "bodies" else group.removesuffix("s")


def _words(entry: Any) -> str:
    """Return the kind of a table, or what else describes it best."""
    if not isinstance(entry, dict):
        return ""
    for key in ("kind", "title", "variants", "run"):
        if entry.get(key):
            value = entry[key]
            return ", ".join(value) if isinstance(value, list) else str(value)
    return ""
