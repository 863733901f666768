"""Beams reduced under any reference condition, from given section matrices, without FEniCSx."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.linalg
from samples.body_specs import CLAMPED, beam_body

from plymotion.preprocess.beam.beam_body import BeamModel, beam_model, beam_modes, beam_package
from plymotion.preprocess.beam.beam_specification import read_spec
from plymotion.preprocess.beam.beam_stations import Stations
from plymotion.preprocess.beam.line import BeamLine, LineSection, SectionMass, on_x_axis
from plymotion.preprocess.modes.reduced import Modes
from plymotion.solver.math.arrays import Array
from plymotion.solver.package import Interface, ModalPackage, SectionData, write_package
from plymotion.solver.package.body.invariants import rigid_motions

CHORD = {"kind": "chord", "at": ["root", "tip"]}
MEAN_AXIS = {"kind": "mean-axis"}
REFERENCES = (CLAMPED, CHORD, MEAN_AXIS)
NAMES = tuple(str(reference["kind"]) for reference in REFERENCES)

INTERFACES = {"root": {"at": "start"}, "mid": {"at": 0.5}, "tip": {"at": "end"}}
# Axial and shear forces, twist and bending of a bulky, soft bar; mass centre off the line.
STIFFNESS = np.diag([4e3, 1e3, 1.2e3, 20.0, 30.0, 25.0])
CENTRE, ROTARY = np.array([0.0, 0.02, -0.01]), np.diag([0.03, 0.018, 0.012])
MASS = SectionMass(1.0, CENTRE, ROTARY).matrix()


def coupled_stiffness(K: np.ndarray = STIFFNESS) -> np.ndarray:
    """The same stiffness with couplings of every kind."""
    A = np.random.default_rng(7).normal(size=(6, 6))
    C = A @ A.T + 6.0 * np.eye(6)
    scale = np.sqrt(np.diag(K) / np.diag(C))
    return C * np.outer(scale, scale)


def modal_mass(stations: Stations) -> np.ndarray:
    """Mass matrix of the modes as a sum over stations, (m, m)."""
    phi, psi = stations.phi_B, stations.psi_B
    translation = np.einsum("k,kai,kaj->ij", stations.m, phi, phi, optimize=True)
    return translation + np.einsum("kai,kab,kbj->ij", psi, stations.J_B, psi, optimize=True)


def dense(K: Any, M: Any, n_mode: int) -> tuple[np.ndarray, np.ndarray]:
    # the inverse pencil gives the lowest frequencies to round-off
    inverse, X = scipy.linalg.eigh(M.toarray(), K.toarray())
    values = 1.0 / inverse[::-1][:n_mode]
    return values, X[:, ::-1][:, :n_mode] * np.sqrt(values)


@dataclass(frozen=True)
class Beam:
    """A reduced beam: the mesh, its modes, the package that the solver reads."""

    model: BeamModel
    modes: Modes
    package: ModalPackage

    def interface(self, name: str) -> Interface:
        return next(i for i in self.package.interfaces if i.name == name)

    def motion(self, name: str) -> np.ndarray:
        """Displacement and rotation of an interface, (6, 6 + m), per frame motion and mode."""
        interface = self.interface(name)
        elastic = np.vstack([interface.phi_B, interface.psi_B])
        return np.hstack([rigid_motions(interface.position_B[None])[0], elastic])

    def stiffness(self) -> np.ndarray:
        """Stiffness (6 + m, 6 + m) of frame motion and modes."""
        m = self.package.n_mode
        K = np.zeros((6 + m, 6 + m))
        K[6:, 6:] = self.package.stiffness
        return K


def reduced(
    reference: dict[str, Any],
    modes: list[dict[str, Any]],
    *,
    elements: int = 4,
    K: np.ndarray = STIFFNESS,
    mass: np.ndarray = MASS,
    sections: Sequence[LineSection] = (),
    **changes: Any,
) -> Beam:
    """A straight beam of 1 m along x, unless `changes` of its specification say otherwise."""
    entries = {
        "body": "beam",
        "length": 1.0,
        "elements": elements,
        "section": {},
        "interfaces": INTERFACES,
        "reference": reference,
        "modes": modes,
        **changes,
    }
    model = beam_model(read_spec(beam_body(**entries)), *(sections or [LineSection(K, mass)]))
    found = beam_modes(model, dense)
    given = [SectionData("bar", s.K, s.mass) for s in model.profile.sections]
    return Beam(model, found, beam_package(model, found, given, {}))


def with_all_modes(reference: dict[str, Any], elements: int = 4, **changes: Any) -> Beam:
    count = 6 * (elements + 1) - 6
    return reduced(reference, [{"kind": "lowest", "count": count}], elements=elements, **changes)


def clamped_file(folder: Path, count: int) -> ModalPackage:
    """Write beam.vtkhdf, a clamped beam with `count` modes of bending, into a folder; return it."""
    package = reduced(CLAMPED, [{"kind": "bending-xy", "count": count}]).package
    write_package(folder / "beam.vtkhdf", package)
    return package


def straight_line(x_B: Array | Sequence[float], K: Array, mass: Array, A_BE: Array) -> BeamLine:
    """A uniform beam along the x axis.

    Parameters
    ----------
    x_B : (n,) node positions, rising [m]
    K, mass : see `LineSection`
    A_BE : (3, 3) section axes in body axes
    """
    section = LineSection(K, mass, np.zeros(6))
    count = len(x_B) - 1
    return BeamLine(
        on_x_axis(x_B), np.tile(A_BE, (count, 1, 1)), (section,), np.zeros(count, dtype=int)
    )


def without_pieces(package: ModalPackage) -> ModalPackage:
    """The package as an earlier version wrote it."""
    assert package.second_order is not None
    return replace(package, second_order=replace(package.second_order, pieces=None))
