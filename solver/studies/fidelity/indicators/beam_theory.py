"""What beam theory leaves out of a body: indicators of the error of signals."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....inputs.section.shapes.library import walls
from ....math.arrays import Array
from ....package import ModalPackage
from ....package.body.selection import vibrations
from ....run.error_bars import held_ends
from ..plan import BodyPlan, Rich, kind_of, number_of
from .response import Indicators

if TYPE_CHECKING:
    from ....inputs.case.tables.schema import Mechanism


def share_of_ends(package: ModalPackage, q: Array) -> float | None:
    """Return what both ends take from the strain energy, at most, over the largest energy.

    So much less do its loads move, relative to what they do; see `held_ends`.

    Parameters
    ----------
    q : (k, m) modal coordinates

    Returns
    -------
    None if the package does not have the data: not a uniform beam with an analysed section.
    """
    ends = held_ends(package)
    if ends is None:
        return None
    lost, energy = (np.einsum("ki,ij,kj->k", q, A, q) for A in (ends, package.stiffness))
    largest = float(energy.max(initial=0.0))
    return float(min(1.0, max(0.0, lost.max(initial=0.0)) / largest)) if largest > 0.0 else 0.0


def held_lengths(package: ModalPackage) -> Array | None:
    """Return the length that a held end takes from a beam under the loads of each mode, (m,) [m].

    The sums of F' S F over those of F' K^-1 F along the beam, with its resultants F in the mode.
    None without the data, as in `share_of_ends`.
    """
    if package.recovery is None or held_ends(package) is None:
        return None
    section, F = package.sections[0], package.recovery.resultants_E
    S, C = np.asarray(section.end_compliance), np.linalg.inv(section.K)
    taken, whole = (np.einsum("sim,ij,sjm->m", F, A, F) for A in (S, C))
    return np.maximum(taken, 0.0) / np.maximum(whole, np.finfo(float).tiny)


POISSON = 0.3
DECAY = 0.3  # of the width: length in which warping decays along a beam
FREE = 4.730  # first root of a strip with free edges


@dataclass(frozen=True)
class Walls:
    """Width of the widest wall and least thickness of a cross-section [m]."""

    width: float
    thickness: float
    hinged: bool = True  # at its edges, as walls that meet in corners are; a solid section is free

    @property
    def thin(self) -> bool:
        """True if a shell is a model of the part: walls, or a strip, below a fifth of the width."""
        return self.thickness < 0.2 * self.width


def local_frequency(walls: Walls, K: Array, M: Array, across: float = 1.0) -> float:
    """Return the first frequency [rad/s] of a long wall: (k / b)^2 sqrt(D / (rho t)).

    k = pi for hinged edges, 4.730 for free ones.

    Parameters
    ----------
    walls : of the section
    K, M : (6, 6) stiffness and mass of the section, which have E / rho along the beam
    across : modulus across the wall over that along it
    """
    speed = np.sqrt(across * K[0, 0] / M[0, 0])
    bending = speed * walls.thickness / np.sqrt(12.0 * (1.0 - POISSON**2))
    k = np.pi if walls.hinged else FREE
    return float((k / walls.width) ** 2 * bending)


def walls_carried(ratio: float) -> float:
    """Return the relative change of a frequency f because walls vibrate with it.

    x^2 / (1 - x^2) / 10, x = f / f_wall (`ratio`); 1 from the frequency of the walls on. A wall
    that is moved by its edges moves by 1 / (1 - x^2); a tenth of it is the share of shells of
    boxes: about half of the mass is in walls across, and their edges are no hinges.
    """
    x2 = ratio**2
    return min(1.0, 0.1 * x2 / (1.0 - x2)) if x2 < 1.0 else 1.0


def warping_decay(walls: Walls, K: Array) -> float:
    """Return the length [m] in which restrained warping of a section decays, an upper estimate.

    sqrt(E I b^2 / (4 G J)): that of an I-section, whose flanges of stiffness E I bend about x3.
    """
    least = float(np.linalg.eigvalsh(K[4:, 4:])[0])
    return float(np.sqrt(least * walls.width**2 / (4.0 * K[3, 3])))


def ovalisation(walls: Walls, curvature: float, across: float = 1.0) -> float:
    """Return the relative loss of bending stiffness of a curved beam.

    The stresses of bending press the walls towards the neutral axis. A square box loses
    (kappa b^2 / t)^2 / 12.6 of its stiffness, a tube of diameter b as much by Brazier's
    3/2 (1 - nu^2) (kappa R^2 / t)^2. A flat strip only loses its curvature across (Lamb, Searle):
    nu^2 (kappa b^2 / t)^2 / 30, at most nu^2 / (1 - nu^2).

    Parameters
    ----------
    walls : of the section
    curvature : kappa [1/m]
    across : modulus across the wall over that along it
    """
    square = (curvature * walls.width**2 / walls.thickness) ** 2 / across
    if walls.hinged:
        return float(min(1.0, square / 12.0))
    return float(min(POISSON**2 / (1.0 - POISSON**2), POISSON**2 * square / 30.0))


def short_waves(walls: Walls, held: float, half_wave: float) -> float:
    """Return the relative change of a frequency because the warping varies along the beam.

    d / (2 d_w) x^2 / (1 + x^2), x = pi d_w / l: warping that a beam takes as that of a uniform
    load varies with the half wave l, and is restrained in part. d_w, the length in which the
    warping decays, is about 0.3 b: between 0.23 b (torsion of a strip) and 0.4 b (its bending).

    Parameters
    ----------
    held : d, the length that a held end takes from the beam under this load [m]
    half_wave : l [m]
    """
    decay = DECAY * walls.width
    x2 = (np.pi * decay / half_wave) ** 2
    return float(min(1.0, 0.5 * held / decay * x2 / (1.0 + x2)))


ACROSS = ("width", "height", "side", "chord")  # sizes of shapes: outer dimensions
ROUND = ("radius", "outer_radius")  # half of one


@dataclass(frozen=True)
class BeamTheory:
    """Indicators of one beam, as errors of the signals, with the numbers behind them.

    Attributes
    ----------
    values : by name: "ends", and of the shapes of the library "walls", "ovalisation", "waves";
        "warping" without "ends" and "waves"
    walls : None of a section that is not of the library
    local_hz : first frequency of the widest wall on its own [Hz]
    """

    name: str
    walls: Walls | None
    length: float
    values: dict[str, float]
    local_hz: float = 0.0

    def enough(self, accuracy: float) -> bool:
        """Tell whether all indicators are below the accuracy."""
        return max(self.values.values()) <= accuracy

    def words(self, accuracy: float) -> str:
        """Return the indicators in words, and what follows from them."""
        size, other = "", "a solid or shell body"
        if self.walls is not None:
            b, t = 1e3 * self.walls.width, 1e3 * self.walls.thickness
            size = (
                f"width {b:.3g} mm, thickness {t:.3g} mm, first frequency of a wall about "
                f"{self.local_hz:.3g} Hz, "
            )
            other = "a shell body" if self.walls.thin else "a solid body"
        numbers = ", ".join(f"{name} {value:.1e}" for name, value in self.values.items())
        text = (
            f"beam theory of {self.name} ({size}length {1e3 * self.length:.4g} mm): "
            f"estimated errors {numbers}"
        )
        if self.walls is None:
            text += "; walls, oval sections and short waves of a described section not checked"
        if self.enough(accuracy):
            known = "" if self.walls is not None else "as far as checked, "
            return f"{text}; {known}a beam is enough for {accuracy:g}"
        worst = [name for name, value in self.values.items() if value > accuracy]
        return f"{text}; {' and '.join(worst)} above {accuracy:g}: {other} is proposed"


def beam_theory(
    mechanism: "Mechanism",
    name: str,
    plan: BodyPlan,
    rich: Rich,
    indicators: Indicators,
) -> BeamTheory | None:
    """Return the indicators of a body; None if it is no uniform beam with an analysed section.

    Parameters
    ----------
    mechanism : of the case
    name : of the body
    plan : the model of the body
    rich : its package with the response to the loads of the run
    indicators : of the run, with what each mode adds to the signals
    """
    body = mechanism.bodies[name]
    package = rich.package
    if body.kind != "beam" or body.length is None or len(package.sections) != 1:
        return None
    walls = walls_of(mechanism.sections[body.section]) if body.section is not None else None
    ends = share_of_ends(package, rich.eta)
    if walls is None and ends is None:
        return None
    worth = {
        mode.label: float(value)
        for mode, value in zip(indicators.modes, indicators.worth({}), strict=True)
        if mode.body == name
    }
    whole = max(worth.values(), default=0.0)
    length, values = float(body.length), {} if ends is None else {"ends": whole * ends}
    if walls is None:
        return BeamTheory(name, None, length, values)
    section = package.sections[0]
    frequencies = dict(zip(package.mode_labels, package.frequencies.tolist(), strict=True))
    # Least modulus across a wall over that along the beam: E2 / E1 of a ply, at most 1.
    material = mechanism.materials.get(body.material) if body.material else None
    one, two = getattr(material, "E1", None), getattr(material, "E2", None)
    ratio = min(1.0, float(two / one)) if one and two else 1.0
    local = local_frequency(walls, section.K, section.M, ratio)
    known = [package.mode_labels[i] for i in vibrations(package).tolist()]
    kept = [label for label in known if label in plan.vibrations]
    if ends is None:
        torsion = max((v for label, v in worth.items() if kind_of(label) == "torsion"), default=0.0)
        values["warping"] = torsion * min(1.0, warping_decay(walls, section.K) / length)
    values |= {
        "walls": sum(worth.get(n, 0.0) * walls_carried(frequencies[n] / local) for n in kept),
        "ovalisation": whole * ovalisation(walls, _curvature(rich), ratio),
    }
    held = held_lengths(package)
    if held is not None:
        lengths = dict(zip(package.mode_labels, held.tolist(), strict=True))
        values["waves"] = sum(
            worth.get(n, 0.0) * short_waves(walls, lengths[n], length / number_of(n)) for n in kept
        )
    return BeamTheory(name, walls, length, values, local / (2.0 * np.pi))


def walls_of(section: Any) -> Walls | None:
    """Return the walls of a section of the library; None of one that is described in a file."""
    if getattr(section, "shape", None) is None:
        return None
    sizes = getattr(section, "values", None)
    if not isinstance(sizes, Mapping):  # the record of a run file has sizes as attributes
        sizes = {key: value for key, value in vars(section).items() if value is not None}
    across = [float(sizes[key]) for key in ACROSS if key in sizes]
    across += [2.0 * float(sizes[key]) for key in ROUND if key in sizes]
    keys = {wall.thickness for wall in walls(section.shape, sizes)} | {"wall"}
    thick = [float(sizes[key]) for key in keys if isinstance(sizes.get(key), float)]
    if not across or not (thick or across):
        return None
    return Walls(max(across), min(thick or across), hinged="wall" in sizes)


def _curvature(rich: Rich) -> float:
    """Largest curvature [1/m] along the beam by the quasi-static response."""
    recovery = rich.package.recovery
    if recovery is None:
        return 0.0
    F = np.einsum("sim,km->ksi", recovery.resultants_E, rich.eta)
    strains = F @ np.linalg.inv(rich.package.sections[0].K).T
    return float(np.linalg.norm(strains[..., 4:], axis=-1).max(initial=0.0))
