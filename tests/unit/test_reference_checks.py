"""What the validator says of shapes that contradict the reference condition of their package."""

import dataclasses

import numpy as np
import pytest
from samples.beam_samples import CHORD, CLAMPED, MEAN_AXIS, NAMES, REFERENCES, reduced
from samples.package_samples import cantilever

from plymotion.solver.package import ModalPackage
from plymotion.solver.package.body.plausibility import reference_findings

MODES = [{"kind": "lowest", "count": 4}, {"kind": "attachment", "at": "mid"}]


def messages(package: ModalPackage) -> list[str]:
    return [f"{f.level} {f.dataset}: {f.message}" for f in reference_findings(package)]


def renamed(package: ModalPackage, condition: str) -> ModalPackage:
    return dataclasses.replace(package, reference_condition=condition)


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
@pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)
def test_packages_of_beams_keep_their_condition(reference: dict, mass_form: str) -> None:
    assert messages(reduced(reference, MODES, mass_form=mass_form).package) == []


def test_every_other_condition_is_doubted() -> None:
    clamped, chord, mean_axis = (reduced(r, MODES).package for r in (CLAMPED, CHORD, MEAN_AXIS))
    for package in (chord, mean_axis):
        (text,) = messages(renamed(package, "clamped"))
        assert text.startswith("warning /modal_package/modes/shapes_B: reference condition is clam")
    for package, found in ((clamped, "found 1 and 0"), (mean_axis, "found 0 and 0")):
        (text,) = messages(renamed(package, "chord"))
        assert found in text
    for package in (clamped, chord, cantilever()):
        linear, angular = messages(renamed(package, "mean-axis"))
        assert "invariants/S_B" in linear
        assert "has linear momentum" in linear
        assert "invariants/T01_B" in angular
        assert "has angular momentum" in angular


def test_angular_momentum_alone_is_seen() -> None:
    """A mode of a mean axis that turns a little: its linear momentum stays zero."""
    package = reduced(MEAN_AXIS, MODES).package
    inv = package.invariants
    T01 = inv.T01_B.copy()
    T01[0, 1, 2] += 1e-4
    turned = dataclasses.replace(package, invariants=dataclasses.replace(inv, T01_B=T01))
    (text,) = messages(turned)
    assert "mode 3 has angular momentum" in text


def test_rigid_body_has_nothing_to_say() -> None:
    package = reduced(CLAMPED, []).package
    assert [messages(renamed(package, name)) for name in NAMES] == [[], [], []]
    assert np.shape(package.mass) == (0, 0)
