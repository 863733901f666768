"""Figures of a section show the content of the section file."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from samples.section_samples import rectangle

from plymotion.solver.package.common.files import RECORD
from plymotion.solver.package.common.recovery_schema import Ply
from plymotion.solver.package.section.section_schema import SectionFile
from plymotion.solver.package.section.stress import cell_means, unit_stress
from plymotion.solver.report.section.drawing import CellField, detail_of, ply_colours, shape_of
from plymotion.solver.report.section.section_figures import draw_section, shear_flow


def with_material(kind: str, *plies: Ply) -> SectionFile:
    section = rectangle()
    recovery = dataclasses.replace(
        section.recovery,
        plies=plies or section.recovery.plies,
        materials={name: {"kind": kind} for name in ("alloy", "resin")},
    )
    return dataclasses.replace(section, recovery=recovery)


def area(polygon: np.ndarray) -> float:
    x, y = polygon.T
    return float(abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)) / 2)


@pytest.mark.parametrize("cell", ["quad9", "triangle6"])
def test_two_figures_of_1200_pixels_appear(tmp_path: Path, cell: str) -> None:
    section = dataclasses.replace(rectangle(cell=cell), name="spar/tip 3")
    figures = draw_section(section, tmp_path / "new")
    assert [path.name for path in figures] == ["spar-tip-3-mesh.png", "spar-tip-3-states.png"]
    assert set((tmp_path / "new").iterdir()) == {*figures, tmp_path / "new" / RECORD}
    for path in figures:
        picture = imread(path)
        assert picture.shape[1] == 1200
        assert 0.02 < np.mean(picture[..., :3].min(axis=2) < 0.99) < 0.7, "blank, or all ink"
    if cell == "quad9":
        one = [path.read_bytes() for path in figures]
        again = [path.read_bytes() for path in draw_section(section, tmp_path / "new")]
        assert again == one, "the same section gives the same picture"


@pytest.mark.parametrize(
    ("height", "material"), [(0.001, "orthotropic"), (0.02, "isotropic"), (0.3, "orthotropic")]
)
def test_flat_and_upright_sections_are_drawn(tmp_path: Path, material: str, height: float) -> None:
    section = rectangle(height=height)
    recovery = dataclasses.replace(section.recovery, materials={"alloy": {"kind": material}})
    far = dataclasses.replace(section, recovery=recovery, shear_centre=np.array([-0.2, 0.01]))
    assert all(path.is_file() for path in draw_section(far, tmp_path))


@pytest.mark.parametrize("cell", ["quad9", "triangle6"])
def test_cells_are_polygons_through_their_edge_nodes(cell: str) -> None:
    section = rectangle(cell=cell)
    mesh = section.mesh
    nodes = mesh.nodes.copy()
    bulge = mesh.connectivity[4] if cell == "quad9" else mesh.connectivity[3]  # middle of a side
    nodes[bulge] += [0.0, -0.001]
    shape = shape_of(dataclasses.replace(mesh, nodes=nodes))
    assert shape.unit == "mm"
    areas = np.array([area(polygon) for polygon in shape.polygons])
    expected = 1e6 * np.bincount(section.recovery.cell, weights=section.recovery.weights)
    extra = areas - expected
    assert extra[0] == pytest.approx(0.5 * 10.0 * 1.0)  # a triangle upon the side of 10 mm
    np.testing.assert_allclose(extra[1:], 0.0, atol=1e-9)


def test_borders_are_the_outer_edge_and_where_regions_meet() -> None:
    section = rectangle()
    shape = shape_of(section.mesh)

    def length(sides: list[np.ndarray]) -> float:
        return float(sum(np.linalg.norm(np.diff(side, axis=0), axis=1).sum() for side in sides))

    alone = np.zeros(24, dtype=int)
    assert length(shape.borders(alone)) == pytest.approx(2 * (60 + 20))
    assert length(shape.borders(section.mesh.region)) == pytest.approx(2 * (60 + 20) + 60)
    assert len(shape.borders(np.arange(24))) == len(shape.sides)


def test_metres_for_large_sections() -> None:
    shape = shape_of(rectangle(width=2.0).mesh)
    assert (shape.unit, shape.size) == ("m", pytest.approx(2.0))


def luminance(colour: tuple[float, float, float]) -> float:
    red, green, blue = colour
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def test_plies_of_one_material_and_angle_share_a_colour() -> None:
    colours, row = ply_colours(with_material("orthotropic"))
    assert [colour.label for colour in colours] == ["alloy  0°", "alloy  +30°", "alloy  −45°"]
    assert row == [0, 1, 0, 2]
    shades = [luminance(colour.colour) for colour in colours]
    assert np.diff(shades).min() > 0.1, "angles must differ in lightness, not in hue alone"


def test_angles_of_isotropic_materials_are_not_shown() -> None:
    plies = (
        Ply("upper", 0, "alloy", 0.0),
        Ply("upper", 1, "alloy", 30.0),
        Ply("lower", 0, "resin", 0.0),
        Ply("lower", 1, "alloy", -45.0),
    )
    colours, row = ply_colours(with_material("isotropic", *plies))
    assert [colour.label for colour in colours] == ["alloy", "resin"]
    assert row == [0, 0, 1, 0]


def test_thin_walls_are_shown_enlarged() -> None:
    thick = with_material("orthotropic")
    assert detail_of(thick, shape_of(thick.mesh)) is None
    thin = rectangle(height=0.002)
    detail = detail_of(thin, shape_of(thin.mesh))
    assert detail is not None
    assert detail.thickness == pytest.approx(1.0), "that of one of two walls"
    assert np.all(detail.low < [30.0, 0.0])
    assert np.all(detail.high > [30.0, 0.0]), "the window holds the end where the walls meet"


def test_shades_are_exact_for_stresses_of_second_degree() -> None:
    """Shear of a rectangle is a parabola: at the corners of the cells it is that parabola."""
    section = rectangle()
    field = CellField(section, shape_of(section.mesh))
    stress = unit_stress(section.recovery)
    x2, _ = field.corners_at.T / 1e3
    expected = 1.5 / 0.0012 * (1 - (x2 / 0.03) ** 2)
    found = field.at_corners(stress[:, 5, 1])
    np.testing.assert_allclose(found, expected, atol=1e-9 * expected.max())


def test_cells_of_two_plies_get_a_plane() -> None:
    section = rectangle()
    mixed = section.recovery.ply.copy()
    mixed[0] = 3 - mixed[0]  # first point of the first cell
    recovery = dataclasses.replace(section.recovery, ply=mixed)
    field = CellField(dataclasses.replace(section, recovery=recovery), shape_of(section.mesh))
    found = field.at_corners(section.recovery.points[:, 0] ** 2)
    exact = (field.corners_at[:, 0] / 1e3) ** 2
    first = field.cells == 0
    np.testing.assert_allclose(found[~first], exact[~first], atol=1e-15)
    assert np.abs(found[first] - exact[first]).max() > 1e-7


def arrows(section: SectionFile, column: int) -> tuple[np.ndarray, np.ndarray]:
    field = CellField(section, shape_of(section.mesh))
    tau = unit_stress(section.recovery)[:, [5, 4], column]
    return shear_flow(field, cell_means(section, tau), step=4.0)


def test_arrows_follow_the_shear_force() -> None:
    _, along_2 = arrows(rectangle(), 1)
    assert np.all(along_2[:, 0] > 0)
    np.testing.assert_allclose(along_2[:, 1], 0, atol=1e-9 * along_2.max())
    _, along_3 = arrows(rectangle(), 2)
    assert np.all(along_3[:, 1] > 0)


def test_arrows_of_torsion_run_round_a_solid_and_back_in_a_thin_wall() -> None:
    for height in (0.06, 0.003):
        places, flow = arrows(rectangle(height=height), 3)
        round_about = places[:, 0] * flow[:, 1] - places[:, 1] * flow[:, 0]
        assert np.all(round_about > 0), "right-handed about x1"
    upper = places[:, 1] > 0
    assert np.all(flow[upper & (np.abs(places[:, 0]) < 20), 0] < 0)
    assert np.all(flow[~upper & (np.abs(places[:, 0]) < 20), 0] > 0)
    assert upper.any()
    assert (~upper).any()


def test_arrows_keep_their_distance() -> None:
    places, flow = arrows(rectangle(cells=(30, 20)), 1)
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2) + 1e9 * np.eye(len(places))
    assert gaps.min() >= 0.8 * 4.0
    assert 20 < len(flow) < 110
