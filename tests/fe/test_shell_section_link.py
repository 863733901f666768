"""Loads at the open end of a thin-walled section: the stresses of Saint-Venant."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.body_specs import shell_body, shell_parts
from samples.shell_layups import BOX_MATERIAL, BOXES, WALL
from samples.shell_meshes import gmsh_file
from samples.shell_model import laminate
from samples.shell_specs import METAL, SCRIPTS, plate

from plymotion.preprocess.body import build_body
from plymotion.preprocess.fenicsx import NamedNodes, PlainMesh
from plymotion.preprocess.shell.analyses.cases import load_cases
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.freedom import Freedom
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.shell_cells import ShellError, ShellMesh
from plymotion.preprocess.shell.shell_mesh import mesh_of
from plymotion.solver.package.shell.shell_schema import ShellCases

QUADS = {"element": "quadrilateral"}


def box(layup: str, kind: str, n: tuple[int, int, int] = (40, 4, 3)) -> dict[str, Any]:
    """The paper's box, clamped at its root, with a link at its open tip."""
    size = dict(zip(("n_length", "n_width", "n_height"), n, strict=True))
    moments = {"Fy": [0.0, 1.0, 0.0], "Fz": [0.0, 0.0, 1.0]}
    turns = {"T": [1.0, 0.0, 0.0], "My": [0.0, 1.0, 0.0], "Mz": [0.0, 0.0, 1.0]}
    return {
        "mesh": {"file": str(SCRIPTS / "box-beam.py"), "parameters": size, **QUADS},
        "materials": {"ply": BOX_MATERIAL},
        "laminates": {w: laminate("ply", p, WALL, "energy-1d") for w, p in BOXES[layup].items()},
        "regions": {w: {"laminate": w, "axis": [1.0, 0.0, 0.0]} for w in BOXES[layup]},
        "supports": {"root": {"at": "root", "fixed": "all"}},
        "links": {"tip": {"at": "tip", "kind": kind}},
        "loads": {
            **{k: {"tip": {"at": "tip-link", "force": v}} for k, v in moments.items()},
            **{k: {"tip": {"at": "tip-link", "moment": v}} for k, v in turns.items()},
        },
    }


def turned(layup: str, kind: str) -> np.ndarray:
    """Motion of the tip's point along each of its loads."""
    spec = box(layup, kind)
    spec["links"] = {"tip-link": spec["links"]["tip"]}
    found, _ = statics(spec)
    rows = [1, 2, 3, 4, 5]
    return found.link_motions_G[range(5), 0, rows]


def statics(spec: dict[str, Any], mesh: Any = None) -> tuple[ShellCases, list[str]]:
    """Load cases, and messages of links that distort; the errors by the mesh are not estimated."""
    problem = ShellProblem(spec, mesh=mesh)
    warnings: list[dict[str, str]] = []
    return load_cases(problem, warnings, lambda _line: None)[0], messages_of(warnings)


@pytest.mark.one_end
@pytest.mark.parametrize("layup", ["0", "cas15", "cus15"])
def test_twist_of_an_open_box(layup: str) -> None:
    """The rigid link holds the section in shape; the averaging link distorts it."""
    rigid, average, section = (turned(layup, kind) for kind in ("rigid", "average", "section"))
    assert section / rigid == pytest.approx(np.ones(5), rel=0.01)
    assert section[2] / rigid[2] == pytest.approx(1.0, rel=0.005)
    assert average[2] / rigid[2] > 1.1


def test_rigid_motions_and_work() -> None:
    spec = box("cas15", "section", (4, 2, 2))
    spec["links"]["tip"]["point"] = [1.1, 0.02, -0.01]
    problem = ShellProblem(spec | {"loads": {}})
    freedom = Freedom(problem.mesh, problem.links)
    rigid = freedom.rigid_motions()
    follow = freedom.expanded(rigid[freedom.free])
    assert np.abs(follow - rigid).max() < 1e-10
    force = np.zeros((freedom.n_dof, 6))
    force[-6:] = np.eye(6)
    nodal = freedom.gathered(force)
    assert np.abs(rigid[freedom.free].T @ nodal - rigid[-6:].T).max() < 1e-10


@pytest.mark.one_end
def test_open_section_and_refusals() -> None:
    """A slit tube carries torsion by the twisting moments of its walls; no straight edge does."""
    size = {"radius": 0.1, "length": 1.0, "first_deg": 20.0, "second_deg": 320.0}
    tube = {
        "mesh": {
            "file": str(SCRIPTS / "cylinder.py"),
            "parameters": {**size, "n_length": 20, "n_around": 24},
            **QUADS,
        },
        "materials": {"metal": METAL},
        "regions": {"all": {"material": "metal", "thickness": 0.005}},
        "supports": {"root": {"at": "near", "fixed": "all"}},
        "links": {"tip": {"at": "far", "kind": "section"}},
        "loads": {"T": {"tip": {"at": "tip", "moment": [1.0, 0.0, 0.0]}}},
    }
    found = analyse(tube).cases
    assert found.reactions_G[0, 0, 3] == pytest.approx(-1.0, rel=1e-6)
    assert found.link_motions_G[0, 0, 3] > 0.0
    flat = plate((4, 2), 0.01, links={"tip": {"at": "right", "kind": "section"}})
    with pytest.raises(ShellError, match=r"links.tip.at = 'right': a straight line; .*average"):
        ShellProblem(flat)
    flat["links"]["tip"]["at"] = "plate"
    with pytest.raises(ShellError, match="a surface; a section link needs a curve"):
        ShellProblem(flat)


def thin_walled(
    shape: str, length: float, kind: str, load: dict[str, Any]
) -> tuple[dict[str, Any], ShellMesh]:
    """A cantilever of walls of 2 mm, clamped at its root, loaded through a link at its open tip."""
    corners = {
        "box": [(-0.05, -0.025), (0.05, -0.025), (0.05, 0.025), (-0.05, 0.025), (-0.05, -0.025)],
        "channel": [(0.05, 0.05), (0.0, 0.05), (0.0, -0.05), (0.05, -0.05)],
    }[shape]
    walls = [np.linspace(a, b, 5)[:-1] for a, b in pairwise(corners)]
    outline = np.concatenate([*walls, np.array(corners[-1:])])
    count, n = len(outline), 41
    ring = np.arange(count)
    if shape == "box":
        ring[-1], count = 0, count - 1
    x = np.repeat(np.linspace(0.0, length, n), count)
    points = np.column_stack([x, np.tile(outline[:count], (n, 1))])
    i = count * np.arange(n - 1)[:, None]
    corner = (i + ring[:-1], i + count + ring[:-1], i + count + ring[1:], i + ring[1:])
    cells = np.stack([part.ravel() for part in corner], axis=1)
    end = np.stack([ring[:-1], ring[1:]], axis=1)
    tags = np.arange(1, len(points) + 1)
    named = NamedNodes(tags, {"root": end, "tip": end + count * (n - 1)}, {})
    region = np.zeros(len(cells), dtype=int)
    spec = {
        "mesh": {"file": "thin-walled.msh"},
        "materials": {"metal": METAL},
        "regions": {"all": {"material": "metal", "thickness": 0.002}},
        "supports": {"root": {"at": "root", "fixed": "all"}},
        "links": {"end": {"at": "tip", "kind": kind}},
        "loads": {"F": {"end": {"at": "end", **load}}},
    }
    plain = PlainMesh(points, cells, "mixed", 1, region, ("wall",), {}, named)
    return spec, mesh_of(plain)


def messages_of(warnings: Any) -> list[str]:
    return [w["message"] for w in warnings if w["code"] == "link-distorts-section"]


TORQUE = {"moment": [1.0, 0.0, 0.0]}
G_METAL = METAL["E"] / 2.6


@pytest.mark.one_end
@pytest.mark.provokes("link-distorts-section")
@pytest.mark.parametrize("length", [0.5, 1.0, 3.0])
def test_torque_at_the_open_end_of_a_box(length: float) -> None:
    """Bredt's twist; the message of the average link has its error, and its advice clears it."""
    bredt = length * 0.3 / (4.0 * 0.005**2 * 0.002 * G_METAL)
    spec, mesh = thin_walled("box", length, "average", TORQUE)
    average = analyse(spec, mesh=mesh)
    (message,) = messages_of(average.warnings)
    assert "link-distorts-section" in {w["code"] for w in average.warnings}
    assert 'use kind = "section" for end' in message
    told = float(message.split("moves ")[1].split(" %")[0])
    twist = average.cases.link_motions_G[0, 0, 3]
    assert 1.0 + 0.01 * told == pytest.approx(twist / bredt, rel=0.02)
    for kind in ("section", "rigid"):
        found, distorted = statics(*thin_walled("box", length, kind, TORQUE))
        assert found.link_motions_G[0, 0, 3] == pytest.approx(bredt, rel=0.015)
        assert distorted == []


@pytest.mark.one_end
@pytest.mark.parametrize(("length", "better"), [(0.5, "average"), (3.0, "section")])
def test_torque_at_the_open_end_of_a_channel(length: float, better: str) -> None:
    """Vlasov's twist with the warping restrained at the root. In a short channel bending of the
    flanges carries the torque, not the twist of the walls of a section link."""
    GJ = G_METAL * 0.2 * 0.002**3 / 3.0
    warping = METAL["E"] * 0.002 * 0.05**3 * 0.1**2 / 12.0 * 0.35 / 0.4
    k = np.sqrt(GJ / warping) * length
    vlasov = length / GJ * (1.0 - np.tanh(k) / k)
    found, distorted = statics(*thin_walled("channel", length, better, TORQUE))
    assert found.link_motions_G[0, 0, 3] == pytest.approx(vlasov, rel=0.025)
    assert distorted == []
    if length < 1.0:
        other, (message,) = statics(*thin_walled("channel", length, "section", TORQUE))
        assert other.link_motions_G[0, 0, 3] > 1.5 * vlasov
        assert 'use kind = "average"' in message


@pytest.mark.one_end
@pytest.mark.parametrize("load", [{"force": [0.1, 0.0, 1.0]}, {"moment": [1.0, 1.0, 0.0]}])
def test_the_second_method_agrees(load: dict[str, Any]) -> None:
    """Its forces come from quadratic functions along the walls, second_route.py."""
    spec, mesh = thin_walled("channel", 0.5, "section", load)
    found = analyse(spec, mesh=mesh, verify=True)
    words = str(found.provenance["verification"])
    assert words.startswith("strain energy of F: difference"), words
    assert float(words.split("difference ")[1].split(" %")[0]) < 6.0
    assert "verification-differs" not in {w["code"] for w in found.warnings}


@pytest.mark.one_end
@pytest.mark.parametrize("kind", ["average", "section"])
@pytest.mark.parametrize(
    "load", [{"force": [1.0, 0.0, 0.0]}, {"moment": [0.0, 1.0, 0.0]}, {"moment": [0.0, 0.0, 1.0]}]
)
def test_loads_that_do_not_distort(kind: str, load: dict[str, Any]) -> None:
    for shape in ("box", "channel"):
        assert statics(*thin_walled(shape, 1.0, kind, load))[1] == []


@pytest.mark.one_end
@pytest.mark.parametrize(("kind", "count"), [("average", 1), ("section", 0)])
def test_interface_of_a_body(kind: str, count: int) -> None:
    modes: list[dict[str, Any]] = [{"kind": "lowest", "count": 4}]
    interfaces = {"root": {"at": "root"}, "end": {"at": "tip", "link": kind}}
    tables = {"body": "box", "shell": shell_parts(box("0", "rigid", (20, 2, 2)))}
    found = build_body(shell_body(**tables, modes=modes, interfaces=interfaces))
    assert messages_of(found.provenance["warnings"]) == []  # no mode is the shape of a torque
    modes.append({"kind": "attachment", "at": "end", "directions": ["rx"]})
    found = build_body(shell_body(**tables, modes=modes, interfaces=interfaces))
    messages = messages_of(found.provenance["warnings"])
    assert len(messages) == count
    assert all('use link = "section" for end' in message for message in messages)


def test_hole_in_a_plate_is_no_section(tmp_path: Path) -> None:
    """Its cells lie in the plane of the curve: there is no member behind it."""
    turn = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    i, j = np.arange(12), np.roll(np.arange(12), -1)
    sides = np.stack([i, j], axis=1)
    tables = {
        "mesh": {
            "file": gmsh_file(
                tmp_path / "ring.msh",
                np.concatenate([circle, 3.0 * circle]).tolist(),
                np.stack([i, i + 12, j + 12, j], axis=1).tolist(),
                "plate",
                {"hole": sides.tolist(), "rim": (sides + 12).tolist()},
            )
        },
        "supports": {"rim": {"at": "rim", "fixed": "all"}},
        "loads": {"T": {"hole": {"at": "hub", "moment": [1.0, 0.0, 0.0]}}},
    }
    hub = {"at": "hole", "kind": "average"}
    assert messages_of(analyse(plate(1, 0.01, links={"hub": hub}, **tables)).warnings) == []
    with pytest.raises(ShellError, match="cells lie in the plane of the curve"):
        ShellProblem(plate(1, 0.01, links={"hub": {**hub, "kind": "section"}}, **tables))
