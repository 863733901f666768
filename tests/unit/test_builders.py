"""Functions of a case, one for each kind: the tables of the case file, signatures, the stub."""

import inspect
from pathlib import Path

import numpy as np
import pytest

import plymotion as pm
from plymotion.api.builders import kinds, signature_of
from plymotion.solver.dynamics.elements.couplings.table import COUPLINGS
from plymotion.solver.dynamics.elements.forces.table import FORCES
from plymotion.solver.dynamics.elements.joints.table import JOINTS


def test_a_model_by_functions(tmp_path: Path) -> None:
    """A double pendulum by functions moves as the same tables do."""
    solver = {"t_end": 0.3, "output_step": 0.01}
    built = pm.Case("by-functions", gravity=[0, 0, -9.81], solver=solver)
    built.point("base", (0, 0, 0))
    inertia = np.diag([1e-3, 0.1, 0.1])
    places = {"root": (0, 0, 0), "tip": (1, 0, 0)}
    arm = built.rigid("arm", mass=1.0, centre=(0.5, 0, 0), inertia=inertia, interfaces=places)
    built.rigid("fore", mass=0.5, inertia=inertia, position=(1, 0, 0), interfaces=places)
    built.revolute("shoulder", "ground.base", "arm.root", axis="y")
    built.revolute("elbow", one="arm.tip", two="fore.root", axis="-y")
    built.rotary_spring("spring", "arm.tip", "fore.root", axis="y", stiffness=3.0)
    built.gear_pair("gear", "shoulder", "elbow", ratio=-2.0)
    built.mass("load", 0.2, "fore.tip")
    built.force("push", "fore.tip", direction="z", law={"constant": 0.5})
    built.signals["angle"] = {"kind": "joint", "joint": "elbow"}
    arm.mass = 1.5  # what a function returns are the keys of the table
    tables = pm.Case("by-tables", **{k: v for k, v in built.table.items() if k != "joints"})
    tables.joints["shoulder"] = {
        "kind": "revolute",
        "between": ["ground.base", "arm.root"],
        "axis": [0, 1, 0],
    }
    tables.joints["elbow"] = {
        "kind": "revolute",
        "between": ["arm.tip", "fore.root"],
        "axis": [0, -1, 0],
    }
    assert built.bodies.arm.mass == 1.5
    found = [
        pm.run(case, out=str(tmp_path / case.name)).signals["angle"] for case in (built, tables)
    ]
    assert np.array_equal(found[0].values, found[1].values)
    assert abs(found[0].final) > 0.1


def test_every_kind_has_its_function() -> None:
    """Joints, couplings and forces of the catalogues, with their own keys and a docstring."""
    known = {kind.name: kind for kind in kinds()}
    assert {*JOINTS, *COUPLINGS, *FORCES} <= known.keys()
    for name, kind in known.items():
        function = getattr(pm.Case, name)
        assert inspect.signature(function) == signature_of(kind)
        for key in signature_of(kind).parameters:
            assert key == "self" or key in inspect.getdoc(function), (name, key)
    assert not {name for name in known if name in vars(pm.Case)}


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda c: c.revolute("j", "ground.a", "b.c", drve={}), r"did you mean 'drive'"),
        (lambda c: c.spring("s", "ground.a", "b.c", stiffness=-1.0), r"^forces\.s\.stiffness = -1"),
        (lambda c: c.revolute("j", "ground.a"), r"Case\.revolute: missing a required argument"),
        (lambda c: c.revolute("j", "ground.a", "rod.a", "y"), "expected name, one, two, and the"),
        (lambda c: c.rigid("b", mass=1.0, inertia=[1, 1, 1]), r"^bodies\.b\.inertia"),
    ],
)
def test_mistakes_are_said_at_once(call, message) -> None:
    """With the key and what was expected; nothing is added."""
    case = pm.Case()
    with pytest.raises(pm.InputError, match=message):
        call(case)
    assert not case.forces
    assert not case.joints


def test_the_stub_is_that_of_the_tables(repository: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`make docs` has been called after a change of keys."""
    monkeypatch.syspath_prepend(str(repository / "tools"))
    from builder_stubs import stub

    assert (repository / "plymotion/api/builders.pyi").read_text("utf-8") == stub()
