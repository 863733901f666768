"""Derivatives by design parameters in packages: written, read, checked, moved along, selected."""

import re
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from samples.package_samples import cantilever, same

from plymotion.solver.errors import InputError, PackageError
from plymotion.solver.math.independent_changes import independent
from plymotion.solver.package import ModalPackage, read_package, validate, write_package
from plymotion.solver.package.body.selection import changed_basis
from plymotion.solver.package.common.dataset import all_values
from plymotion.solver.package.common.design import PLACES, Derivative, differenced, moved
from plymotion.solver.package.common.object_file import PACKED, unpacked
from plymotion.solver.package.validation import write_valid

TARGETS = ({"of": "section.regions.wall.plies.0.angle_deg", "factor": -1.0, "offset": 90.0},)


def numbers(package: ModalPackage) -> dict[str, np.ndarray]:
    found = {path: np.asarray(value) for path, value in all_values(package).items()}
    return {path: value for path, value in found.items() if value.dtype.kind == "f"}


def designed() -> ModalPackage:
    """Every dataset grows by a tenth of itself per unit of `a`, the stiffness twice that of `b`."""
    package = cantilever()
    tenth = {path: 0.1 * value for path, value in numbers(package).items()}
    stiffer = {"modes/stiffness": 2.0 * package.stiffness}
    return replace(
        package,
        design=(Derivative("b", "number", (), stiffer), Derivative("a", "angle", TARGETS, tenth)),
    )


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("design") / "arm.vtkhdf"
    write_package(target, designed())
    return target


def test_a_file_returns_what_was_written_in_its_order(file: Path) -> None:
    assert validate(file) == []
    for _ in range(2):  # from the file, then from the cache
        found = read_package(file).design
        assert [(one.name, one.kind, one.targets) for one in found] == [
            ("b", "number", ()),
            ("a", "angle", TARGETS),
        ]
        for one, known in zip(found, designed().design, strict=True):
            assert one.values.keys() == known.values.keys()
            assert all(np.array_equal(one.values[p], known.values[p]) for p in known.values)


def test_another_process_gets_what_a_file_returns(tmp_path: Path) -> None:
    packed, whole = tmp_path / f"arm{PACKED}", designed()
    made = replace(whole, damping=np.zeros((4, 4), dtype=int))
    write_valid(packed, made, "body arm", own=True)
    write_package(tmp_path / "arm.vtkhdf", made)
    found, read = unpacked(packed.read_bytes()), read_package(tmp_path / "arm.vtkhdf")
    assert same(found, read)
    assert found.damping.dtype == read.damping.dtype
    rates = [rate for one in found.design for rate in one.values.values()]
    assert any(rate.ndim == 0 for rate in rates)  # that of the mass
    values = {**whole.design[1].values, "invariants/S_B": np.full((3, 4), np.nan)}
    wrong = replace(whole, design=(replace(whole.design[1], values=values),))
    with pytest.raises(InputError, match=r"body arm: .*design/a/invariants/S_B: expected finite"):
        write_valid(packed, wrong, "body arm", own=True)
    assert same(unpacked(packed.read_bytes()), read)  # what was there stays


def test_a_package_moves_with_all_its_numbers(file: Path) -> None:
    package = read_package(file)
    now = numbers(moved(package, {"a": 2.0, "b": -0.25}))
    for path, value in numbers(package).items():
        factor = 0.7 if path == "modes/stiffness" else 1.2
        np.testing.assert_allclose(now[path], factor * value, rtol=1e-14)
    with pytest.raises(PackageError, match=r"no derivative by the design parameter 'c'; .* b, a"):
        moved(package, {"c": 1.0})


def test_some_modes_keep_derivatives_that_stay_exact() -> None:
    package = designed()
    some = changed_basis(package, np.eye(4)[:, [2, 0]])
    rate = {one.name: one.values for one in some.design}
    np.testing.assert_array_equal(rate["a"]["modes/stiffness"], 0.1 * some.stiffness)
    np.testing.assert_array_equal(rate["a"]["invariants/T11_B"], 0.1 * some.invariants.T11_B)
    # b turns the first two modes into each other: without one of them it has no derivative
    turning = np.zeros((4, 4))
    turning[0, 1] = turning[1, 0] = 1.0
    b = replace(package.design[0], values={"modes/stiffness": turning})
    package = replace(package, design=(b, package.design[1]))
    with pytest.raises(PackageError, match=r"derivatives by b, but a selection .* equal frequency"):
        changed_basis(package, np.eye(4)[:, [2, 0]])
    assert [d.name for d in changed_basis(package, np.eye(4)[:, [1, 0]]).design] == ["b", "a"]
    with pytest.raises(PackageError, match=r"derivatives by b, .* modes are new combinations"):
        changed_basis(package, np.ones((4, 1)))


def test_five_points_are_exact_for_a_quartic() -> None:
    at = [{"y": np.array([x**4 - 3.0 * x]), "same": np.ones(3), "n": np.arange(2)} for x in
          (1.0 + 0.1 * place for place in PLACES)]  # fmt: skip
    found = differenced(at, 0.1)
    assert found.keys() == {"y"}
    np.testing.assert_allclose(found["y"], 1.0, rtol=1e-12)


def test_changes_are_made_of_the_independent_ones() -> None:
    """Of arrays of any size: two ways, also where a change is zero or there is none."""
    one = {"K": np.diag([1e9, 2e9]), "m": np.array([1e-6])}
    two = {"m": np.array([3e-6])}
    sum_ = {"K": 0.5 * one["K"], "m": 0.5 * one["m"] - 4.0 * two["m"]}
    values, changes = {"K": 1e12 * np.eye(2), "m": np.array([1e-3])}, [{}, two, sum_, one, two]
    kept, shares = independent(values, changes, 1e-12)
    assert len(kept) == 2
    for change, share in zip(changes, shares.T, strict=True):
        for name, zero in (("K", np.zeros((2, 2))), ("m", np.zeros(1))):
            made = sum(s * changes[k].get(name, zero) for k, s in zip(kept, share, strict=True))
            size = np.abs(one[name]).max()
            np.testing.assert_allclose(made, change.get(name, zero), rtol=0.0, atol=1e-12 * size)
    assert independent(values, [{}], 1e-12)[1].shape == (0, 1)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda a: a.create_dataset("modes/mas", data=np.ones(2)), "design/a/modes/mas.*below /mo"),
        (lambda a: a.create_dataset("mesh/offsets", data=np.ones(17)), "a/mesh/offsets.*numbers"),
        (lambda a: a["invariants/S_B"].write_direct(np.full((3, 4), np.nan)), "a/inv.*S_B.*finite"),
        (lambda a: a.attrs.modify("targets", "[1]"), "design/a: attribute targets: expected"),
    ],
)
def test_wrong_derivatives_are_named(
    file: Path, tmp_path: Path, damage: object, message: str
) -> None:
    changed = tmp_path / "arm.vtkhdf"
    changed.write_bytes(file.read_bytes())
    with h5py.File(changed, "r+") as h5:
        del h5.attrs["content_sha256"]
        damage(h5["modal_package/design/a"])  # type: ignore[operator]
    errors = [f"{f.dataset}: {f.message}" for f in validate(changed) if f.level == "error"]
    assert len(errors) == 1
    assert re.search(message, errors[0])
    with pytest.raises(PackageError, match=message):
        read_package(changed)


def test_a_wrong_shape_is_not_written(tmp_path: Path) -> None:
    wrong = Derivative("a", "angle", (), {"modes/stiffness": np.ones((4, 3))})
    with pytest.raises(PackageError, match=r"design/a/modes/stiffness: expected numbers of the sh"):
        write_package(tmp_path / "a.vtkhdf", replace(cantilever(), design=(wrong,)))
    assert list(tmp_path.iterdir()) == []
