"""Places of a body that are loaded: for the shapes of `[fidelity]`, and for the check of modes."""

from samples.fidelity_samples import INTERFACES, pendulum

from plymotion.solver.inputs.case.bodies.specifications import TURNING, rich_bodies
from plymotion.solver.inputs.case.record import loaded_places
from plymotion.solver.inputs.case.tables.schema import Mechanism
from plymotion.solver.package.body.invariants import MOST_MODES


def attachments(mechanism: Mechanism, name: str) -> list[str]:
    model, _ = rich_bodies(name, mechanism)
    return [mode.at for mode in model.modes if mode.kind == "attachment"]


def test_a_force_along_the_coordinate_of_a_joint_adds_no_place():
    table = pendulum(links=2)
    plain = Mechanism.model_validate(table)
    table["forces"] = {
        "damping": {"kind": "friction", "joint": "hinge1", "coulomb": 0.1, "rest_velocity": 0.01}
    }
    rubbed = Mechanism.model_validate(table)
    assert loaded_places("link0", rubbed) == ["root", "tip"]
    assert attachments(rubbed, "link0") == attachments(plain, "link0") == ["tip"]


def test_each_place_once_in_the_order_of_use():
    table = pendulum(links=2)
    table["forces"] = {
        "rope": {"kind": "spring", "between": ["ground.origin", "link1.tip"], "stiffness": 1.0}
    }
    mechanism = Mechanism.model_validate(table)
    assert loaded_places("link1", mechanism) == ["root", "tip"]
    assert loaded_places("link0", mechanism) == ["root", "tip"]


def test_many_places_leave_second_order_displacements_their_room():
    """With more modes the check would be linear, whatever the spin."""
    table = pendulum(links=2)
    table["bodies"]["link0"]["interfaces"] = INTERFACES | {"quarter": {"at": 0.25}}
    for place in ("mid", "quarter"):
        table["masses"][place] = {"mass": 0.1, "at": f"link0.{place}"}
    mechanism = Mechanism.model_validate(table)
    assert loaded_places("link0", mechanism, TURNING) == ["root", "tip"]
    _, check = rich_bodies("link0", mechanism)
    shapes = {mode.at: len(mode.directions) for mode in check.modes if mode.kind == "attachment"}
    assert shapes == {"mid": 3, "tip": 6, "quarter": 3}
    vibrations = sum(getattr(mode, "count", 0) for mode in check.modes)
    assert vibrations + sum(shapes.values()) + 7 <= MOST_MODES
    table["forces"] = {
        "twist": {
            "kind": "torque",
            "at": "link0.mid",
            "direction": [1.0, 0.0, 0.0],
            "law": {"constant": 1.0},
        }
    }
    assert loaded_places("link0", Mechanism.model_validate(table), TURNING) == [
        "root",
        "tip",
        "mid",
    ]
