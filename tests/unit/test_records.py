"""Our dataclasses behave like those of the standard library."""

import copy
import dataclasses
import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from plymotion.solver.math import records

Made = Callable[..., Any]


def classes(made: Made) -> tuple[Any, Any, Any]:
    """A frozen class, one that inherits from it by keywords alone, and one that changes."""

    @made(frozen=True)
    class Point:
        x: float
        y: float = 2.0
        names: list[str] = dataclasses.field(default_factory=list)
        note: str = dataclasses.field(default="", compare=False)
        norm: float = dataclasses.field(init=False, compare=False, default=0.0)

        def __post_init__(self) -> None:
            object.__setattr__(self, "norm", abs(self.x) + abs(self.y))

    @made(frozen=True, kw_only=True)
    class Named(Point):
        name: str
        number: int = 3

    @made(eq=False)
    class State:
        value: int
        seen: dict[str, int] = dataclasses.field(default_factory=dict)

    return Point, Named, State


def told(action: Callable[[], object]) -> object:
    """What an action returns, or the class of its error."""
    try:
        return action()
    except Exception as error:
        return type(error)


ACTIONS = {
    "of values": lambda P, N, S: P(1.0, 3.0, ["a"], "b"),
    "of names": lambda P, N, S: P(y=1.0, x=2.0),
    "of keywords": lambda P, N, S: N(1.0, name="n"),
    "completed": lambda P, N, S: P(1.0, -3.0).norm,
    "too many": lambda P, N, S: P(1.0, 2.0, [], "", 5.0),
    "too few": lambda P, N, S: P(),
    "twice": lambda P, N, S: P(1.0, x=1.0),
    "unknown": lambda P, N, S: P(1.0, z=1.0),
    "unknown in place of a missing one": lambda P, N, S: P(y=1.0, z=1.0),
    "of no keyword": lambda P, N, S: N(1.0, 2.0, [], "", "n"),
    "not given": lambda P, N, S: P(1.0, norm=1.0),
    "own default": lambda P, N, S: (S(1).seen is S(1).seen, P(1.0).names is P(1.0).names),
    "set": lambda P, N, S: setattr(P(1.0), "x", 2.0),
    "deleted": lambda P, N, S: delattr(P(1.0), "x"),
    "changed": lambda P, N, S: setattr(S(1), "value", 2),
    "equal": lambda P, N, S: (P(1.0) == P(1.0, note="n"), P(1.0) == P(2.0), P(1.0) == 1.0),
    "of classes": lambda P, N, S: P(1.0) == N(1.0, name=""),
    "itself": lambda P, N, S: (S(1) == S(1), isinstance(hash(S(1)), int)),
    "hash": lambda P, N, S: hash(P(1.0, names=())) == hash(P(1.0, names=(), note="n")),
    "hash of a list": lambda P, N, S: hash(P(1.0)),
    "replaced": lambda P, N, S: dataclasses.replace(N(1.0, name="n"), y=5.0).norm,
    "replaced by no field": lambda P, N, S: dataclasses.replace(P(1.0), z=5.0),
    "data": lambda P, N, S: dataclasses.asdict(N(1.0, name="n")),
    "attributes": lambda P, N, S: sorted(vars(N(1.0, name="n", y=3.0))),
    "copy": lambda P, N, S: copy.deepcopy(P(1.0, names=["a"])),
    "fields": lambda P, N, S: [f.name for f in dataclasses.fields(N)],
}


@pytest.mark.parametrize("action", ACTIONS.values(), ids=ACTIONS)
def test_a_class_behaves_like_a_dataclass(action: Callable[..., object]) -> None:
    own, expected = classes(records.dataclass), classes(dataclasses.dataclass)
    assert repr(told(lambda: action(*own))) == repr(told(lambda: action(*expected)))


@records.dataclass(frozen=True)
class Kept:
    value: float


def test_objects_are_pickled() -> None:
    assert pickle.loads(pickle.dumps(Kept(2.0))) == Kept(2.0)


def test_the_product_has_no_other_dataclasses() -> None:
    root = Path(__file__).parents[2]
    files = {
        p for half in ("solver", "preprocess", "plymotion") for p in root.glob(f"{half}/**/*.py")
    }
    other = re.compile(r"^from dataclasses import .*\bdataclass\b|@dataclasses\.", re.MULTILINE)
    found = [str(p) for p in files if other.search(p.read_text("utf-8"))]
    assert [p for p in found if not p.endswith("math/records.py")] == []
