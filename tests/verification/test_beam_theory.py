"""Indicators of what beam theory leaves out, on bodies where a beam is enough and where not."""

from dataclasses import replace

import numpy as np
import pytest
from samples.beam_samples import reduced
from samples.fidelity_samples import pendulum, planned_run

from plymotion.solver.inputs.case.tables.bodies import DescribedSection
from plymotion.solver.package import ModalPackage
from plymotion.solver.studies.fidelity.answer import answer_text, entry
from plymotion.solver.studies.fidelity.checked_run import plan_of
from plymotion.solver.studies.fidelity.indicators.beam_theory import (
    Walls,
    held_lengths,
    local_frequency,
    ovalisation,
    share_of_ends,
    short_waves,
    warping_decay,
)
from plymotion.solver.studies.fidelity.plan import with_values

E, NU, RHO = 70e9, 0.3, 2700.0


def test_a_wall_is_a_hinged_plate_strip() -> None:
    """(pi / b)^2 sqrt(D / (rho t)) of a long plate."""
    b, t = 0.1, 1e-3
    K, M = np.zeros((6, 6)), np.zeros((6, 6))
    K[0, 0], M[0, 0] = E * 4 * b * t, RHO * 4 * b * t
    D = E * t**3 / (12.0 * (1.0 - NU**2))
    expected = (np.pi / b) ** 2 * np.sqrt(D / (RHO * t))
    assert local_frequency(Walls(b, t), K, M) == pytest.approx(expected, rel=1e-12)
    free = local_frequency(Walls(b, t, hinged=False), K, M)
    assert free == pytest.approx(22.37 / np.pi**2 * expected, rel=1e-3)


def test_warping_of_an_i_section_decays_as_vlasov_says() -> None:
    """sqrt(E I_w / (G J)) with I_w = I_3 h^2 / 4."""
    h, b, t = 0.2, 0.1, 8e-3
    I3, J = 2.0 * t * b**3 / 12.0, (2.0 * b + h) * t**3 / 3.0
    G = E / (2.0 * (1.0 + NU))
    K = np.diag([1e9, 1e8, 1e8, G * J, E * 2.0 * b * t * (h / 2) ** 2, E * I3])
    expected = np.sqrt(E * I3 * h**2 / 4.0 / (G * J))
    assert warping_decay(Walls(h, t), K) == pytest.approx(expected, rel=1e-12)
    assert expected > 3.0 * h  # a solid section has less than its own height


def test_ovalisation_is_that_of_brazier_for_a_tube() -> None:
    """M = E I kappa (1 - 3/2 zeta), zeta = (1 - nu^2) (kappa R^2 / t)^2."""
    R, t, kappa = 0.05, 1e-3, 1e-2
    brazier = 1.5 * (1.0 - NU**2) * (kappa * R**2 / t) ** 2
    walls = Walls(2.0 * R, t)
    assert ovalisation(walls, kappa) == pytest.approx(brazier, rel=0.03)
    assert ovalisation(walls, kappa, across=0.1) == pytest.approx(10.0 * brazier, rel=0.03)
    assert ovalisation(walls, 1e3) == 1.0
    strip = Walls(2.0 * R, t, hinged=False)  # loses the curvature across at most
    assert ovalisation(strip, kappa) < 0.05 * brazier
    assert ovalisation(strip, 1e3) == pytest.approx(1.0 / (1.0 - NU**2) - 1.0)


def test_short_waves_restrain_the_warping_of_torsion_as_vlasov_says() -> None:
    """A strip twists with G J + E Gamma (pi / l)^2, Gamma = (b t)^3 / 144."""
    b, t = 0.1, 4e-3
    GJ, stiffness = E / (2.0 * (1.0 + NU)) * b * t**3 / 3.0, E * (b * t) ** 3 / 144.0
    held = np.sqrt(stiffness / GJ)
    for half_wave in (0.2, 0.5, 1.0):
        exact = np.sqrt(1.0 + stiffness / GJ * (np.pi / half_wave) ** 2) - 1.0
        assert short_waves(Walls(b, t), held, half_wave) == pytest.approx(exact, rel=0.5)


def test_the_length_that_a_held_end_takes_from_a_mode() -> None:
    """Bending about x3 has it; torsion does not."""
    asked = [{"kind": kind, "count": 1} for kind in ("bending-xy", "torsion")]
    K = np.diag([1e9, 1e9, 1e9, 1e3, 1e3, 25.0])
    package = reduced({"kind": "clamped", "at": "root"}, asked, K=K, elements=16).package
    assert held_lengths(package) is None
    found = held_lengths(with_ends(package, 0.02))
    assert found is not None
    lengths = dict(zip(package.mode_labels, found, strict=True))
    assert lengths["bending-xy 1"] == pytest.approx(0.02, rel=1e-3)
    assert abs(lengths["torsion 1"]) < 1e-3 * 0.02


def with_ends(package: ModalPackage, length: float) -> ModalPackage:
    """The package with a section whose held ends take this length of bending about x3."""
    (section,) = package.sections
    S = np.zeros((6, 6))
    S[5, 5] = length / section.K[5, 5]
    return replace(package, sections=(replace(section, end_compliance=S),))


def test_a_held_end_takes_three_times_its_length_from_a_cantilever() -> None:
    """Under a force at the tip the moment is F L at the end: F^2 L^2 d / B of F^2 L^3 / (3 B)."""
    tip = [{"kind": "attachment", "at": "tip", "directions": ["y"]}]
    K = np.diag([1e9, 1e9, 1e9, 1e3, 1e3, 25.0])
    package = reduced({"kind": "clamped", "at": "root"}, tip, K=K, elements=16).package
    q = np.array([[0.0], [1e-3], [-2e-3]])
    assert share_of_ends(package, q) is None  # a section without the data
    for length in (0.01, 0.02):
        share = share_of_ends(with_ends(package, length), q)
        assert share == pytest.approx(3.0 * length, rel=1e-3)
    assert share_of_ends(with_ends(package, 0.01), 0.0 * q) == 0.0


def test_a_solid_is_proposed_where_the_ends_take_too_much() -> None:
    """The true difference of the deflection is that of a model with less compliance."""
    table = pendulum(signals=["bending"], accuracy=1e-2)
    spec, check = planned_run(table, "soft")
    for length, text in ((1e-4, "a beam is enough"), (0.03, "a solid body is proposed")):
        packages = {"link0": with_ends(spec.packages["link0"], length)}
        (line,) = entry(plan_of(replace(spec, packages=packages), check))["theories"]
        assert text in line
        assert "estimated errors ends " in line
        assert "warping" not in line


def test_a_described_section_has_the_indicator_of_its_ends_alone() -> None:
    table = pendulum(signals=["bending"], accuracy=1e-2)
    spec, check = planned_run(table, "soft")
    sections = {"bar": DescribedSection(description={"mesh": {}})}
    mechanism = with_values(spec.mechanism, sections=sections)
    for length, text in (
        (1e-4, "as far as checked, a beam is enough for 0.01"),
        (0.03, "ends above 0.01: a solid or shell body is proposed"),
    ):
        packages = {"link0": with_ends(spec.packages["link0"], length)}
        described = replace(spec, mechanism=mechanism, packages=packages)
        (line,) = entry(plan_of(described, check))["theories"]
        assert "walls, oval sections and short waves of a described section not checked" in line
        assert line.endswith(text)


def words_of(section: dict[str, object]) -> tuple[list[str], str]:
    """What a plan says of a flexible arm with a section of this shape."""
    table = pendulum(signals=["bending"], accuracy=1e-3)
    table["sections"]["bar"] = section
    answer = plan_of(*planned_run(table, "soft"))
    return entry(answer)["theories"], answer_text(answer)


def test_a_solid_bar_is_a_beam() -> None:
    (line,), text = words_of({"shape": "rectangle", "width": 0.04, "height": 0.01})
    assert "a beam is enough for 0.001" in line
    assert "width 40 mm, thickness 10 mm" in line
    assert line[1:] in text


def test_a_shell_is_proposed_for_walls_that_vibrate() -> None:
    """Walls of 0.1 mm have lower frequencies than the bending of the arm."""
    section = {"shape": "box", "width": 0.1, "height": 0.1, "wall": 1e-4}
    (line,), text = words_of(section)
    assert "a shell body is proposed" in line
    assert "walls" in line.rpartition(";")[2]
    assert line[1:] in text
