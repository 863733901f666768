"""What beam theory leaves out of a body: indicators of the error of signals.

A beam has rigid cross-sections (apart from the warping of its section analysis). A shell or solid
of the same part has more: ends whose sections cannot warp, walls that vibrate on their own,
cross-sections that become oval, waves that are not long against the width. Each indicator is an
estimate of the order of the error; a shell or solid is proposed only where one is above the
accuracy: a shell of a section with thin walls, else a solid.

    ends         share of the strain energy that held ends take (section_ends.py), of any section
    walls        change of the frequency of vibration j by that of the widest wall on its own
    warping      d / L for torsion, with the decay length d of restrained warping; only if the
                 package of a section has no data for `ends`
    ovalisation  loss of the bending stiffness of the bent section, relative
    waves        restrained warping of vibration j, whose half wave l_j = L / j is not long against
                 the width; of packages with data for `ends`

Each is multiplied by what the vibrations contribute to the signals.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..inputs.section.shapes.library import walls
from ..package.body.selection import vibrations
from .indicators import Indicators
from .model import Rich
from .plan import BodyPlan, kind_of
from .section_ends import held_lengths, share_of_ends
from .section_walls import (
    Walls,
    local_frequency,
    ovalisation,
    short_waves,
    walls_carried,
    warping_decay,
)

if TYPE_CHECKING:
    from ..inputs.case.schema import Mechanism

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
    """Return the indicators of a body; None if it is no uniform beam with an analysed section."""
    body = mechanism.bodies[name]
    package = rich.package
    if body.kind != "beam" or body.length is None or len(package.sections) != 1:
        return None
    found = walls_of(mechanism.sections[body.section]) if body.section is not None else None
    ends = share_of_ends(package, rich.eta)
    if found is None and ends is None:
        return None
    worth = {
        mode.label: float(value)
        for mode, value in zip(indicators.modes, indicators.worth({}), strict=True)
        if mode.body == name
    }
    whole = max(worth.values(), default=0.0)
    length, values = float(body.length), {} if ends is None else {"ends": whole * ends}
    if found is None:
        return BeamTheory(name, None, length, values)
    section = package.sections[0]
    frequencies = dict(zip(package.mode_labels, package.frequencies.tolist(), strict=True))
    ratio = _across(mechanism, body)
    local = local_frequency(found, section.K, section.M, ratio)
    known = [package.mode_labels[i] for i in vibrations(package).tolist()]
    kept = [label for label in known if label in plan.vibrations]
    if ends is None:
        torsion = max((v for label, v in worth.items() if kind_of(label) == "torsion"), default=0.0)
        values["warping"] = torsion * min(1.0, warping_decay(found, section.K) / length)
    values |= {
        "walls": sum(worth.get(n, 0.0) * walls_carried(frequencies[n] / local) for n in kept),
        "ovalisation": whole * ovalisation(found, _curvature(rich), ratio),
    }
    held = held_lengths(package)
    if held is not None:
        lengths = dict(zip(package.mode_labels, held.tolist(), strict=True))
        values["waves"] = sum(
            worth.get(n, 0.0) * short_waves(found, lengths[n], length / _number(n)) for n in kept
        )
    return BeamTheory(name, found, length, values, local / (2.0 * np.pi))


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


def _across(mechanism: "Mechanism", body: Any) -> float:
    """Least modulus across a wall over that along the beam: E2 / E1 of a ply, at most 1."""
    material = mechanism.materials.get(body.material) if body.material else None
    one, two = getattr(material, "E1", None), getattr(material, "E2", None)
    return min(1.0, float(two / one)) if one and two else 1.0


def _number(label: str) -> int:
    number = label.rpartition(" ")[2]
    return int(number) if number.isdigit() else 1
