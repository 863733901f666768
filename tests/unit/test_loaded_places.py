"""Places of a body that are loaded: for the shapes of `[fidelity]`, and for the check of modes."""

from samples.fidelity_samples import pendulum

from plymotion.solver.inputs.case.bodies.specifications import rich_bodies
from plymotion.solver.inputs.case.record import loaded_places
from plymotion.solver.inputs.case.tables.schema import Mechanism


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
