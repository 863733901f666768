"""Views of bodies: what is drawn is made when it is asked for."""

import dataclasses
import pickle

import numpy as np

from plymotion.solver.results.run_result import BodyView, Surface
from plymotion.solver.results.surfaces import rigid_surface


def test_a_surface_is_made_once_and_goes_to_other_processes() -> None:
    made = []

    def draw() -> Surface:
        made.append(rigid_surface(np.eye(3), np.zeros(3), np.ones(3), np.eye(3), 0.1, np.inf))
        return made[-1]

    view = BodyView(
        first_position=0,
        shapes_B=np.zeros((0, 3, 6)),
        stiffness=np.zeros((0, 0)),
        frequencies=np.zeros(0),
        labels=(),
        mass=1.0,
        centre_B=np.zeros(3),
        draw=draw,
    )
    assert not made
    assert view.surface is view.surface is made[0]
    there = pickle.loads(pickle.dumps(view))
    for other in (there, dataclasses.replace(there, mass=2.0)):
        for name, values in vars(view.surface).items():
            np.testing.assert_array_equal(getattr(other.surface, name), values)
    assert len(made) == 1
