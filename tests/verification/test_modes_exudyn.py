"""Eigenvalues of a damped, constrained mechanism against Exudyn's, if it is installed."""

import numpy as np
import pytest
from samples.case_samples import rigid
from samples.modes_samples import modes_at

# Two bars, jointed to each other and to the ground by balls, on springs and dampers.
MASS, INERTIA = (2.0, 3.0), ((0.02, 0.2, 0.21), (0.03, 0.3, 0.28))
SPRINGS = ((1, (0.5, 0.0, 0.0), (900.0, 700.0, 400.0), (3.0, 2.0, 4.0)),
           (1, (0.1, 0.2, 0.0), (300.0, 500.0, 800.0), (1.0, 5.0, 2.0)),
           (0, (0.2, 0.1, 0.1), (200.0, 600.0, 900.0), (2.0, 1.0, 1.0)))  # fmt: skip
CENTRES = ((0.5, 0.0, 0.0), (1.5, 0.0, 0.0))


def ours(folder, capsys):
    points = [{"a": (-0.5, 0, 0), "b": (0.5, 0, 0)} for _ in range(2)]
    for k, (body, at, *_) in enumerate(SPRINGS):
        points[body][f"s{k}"] = at
    text = "[ground.o]\nposition = [0.0, 0.0, 0.0]\n"
    for k, name in enumerate(("one", "two")):
        text += rigid(name, MASS[k], INERTIA[k], points[k], position=CENTRES[k])
    for name, pair in (("foot", '"ground.o", "one.a"'), ("knee", '"one.b", "two.a"')):
        text += f'[joints.{name}]\nkind = "spherical"\nbetween = [{pair}]\n'
    for k, (body, at, stiffness, damping) in enumerate(SPRINGS):
        place = [float(c + x) for c, x in zip(CENTRES[body], at, strict=True)]
        text += (
            f"[ground.s{k}]\nposition = {place}\n"
            f'[forces.s{k}]\nkind = "bushing"\n'
            f'between = ["ground.s{k}", "{("one", "two")[body]}.s{k}"]\n'
            f"stiffness = {list(stiffness)}\ndamping = {list(damping)}\n"
        )
    found = modes_at(folder, text, "equilibrium", capsys=capsys)
    return [complex(*m["eigenvalue"]) for m in found["modes"]]


def exudyns():
    exu = pytest.importorskip("exudyn")
    import exudyn.itemInterface as items
    from exudyn.utilities import InertiaCuboid  # noqa: F401  loads what bodies need

    system = exu.SystemContainer()
    mbs = system.AddSystem()
    ground = mbs.AddObject(items.ObjectGround())
    bodies = []
    for mass, inertia, centre in zip(MASS, INERTIA, CENTRES, strict=True):
        node = mbs.AddNode(
            items.NodeRigidBodyEP(
                referenceCoordinates=[*centre, 1, 0, 0, 0], initialVelocities=[0.0] * 7
            )
        )
        bodies.append(
            mbs.AddObject(
                items.ObjectRigidBody(
                    physicsMass=mass, physicsInertia=[*inertia, 0, 0, 0], nodeNumber=node
                )
            )
        )

    def marker(body, place):
        return mbs.AddMarker(
            items.MarkerBodyPosition(bodyNumber=body, localPosition=list(map(float, place)))
        )

    for one, two in (
        (marker(ground, (0, 0, 0)), marker(bodies[0], (-0.5, 0, 0))),
        (marker(bodies[0], (0.5, 0, 0)), marker(bodies[1], (-0.5, 0, 0))),
    ):
        mbs.AddObject(items.ObjectJointSpherical(markerNumbers=[one, two]))
    for body, at, stiffness, damping in SPRINGS:
        place = np.add(CENTRES[body], at)
        pair = [marker(ground, place), marker(bodies[body], at)]
        mbs.AddObject(
            items.CartesianSpringDamper(
                markerNumbers=pair, stiffness=list(stiffness), damping=list(damping)
            )
        )
    mbs.Assemble()
    values, _ = mbs.ComputeODE2Eigenvalues(
        computeComplexEigenvalues=True, useAbsoluteValues=False, ignoreAlgebraicEquations=False
    )
    return np.asarray(values)


def test_damped_mechanism(tmp_path, capsys):
    expected = exudyns()
    found = ours(tmp_path, capsys)
    assert len(found) >= 6
    for value in found:
        assert np.abs(expected - value).min() < 1e-5 * abs(value)
