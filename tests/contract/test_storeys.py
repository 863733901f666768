"""Rooms of solver/ and folders of both halves: the direction of their imports, and their size.

The rooms are described in docs/architecture.md; tools/structure.py reads the imports.
"""

import re
import tomllib
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType

import pytest
from harness.source_copy import recipe_files

MOST_ROOMS, MOST_LEVELS = 20, 10
MOST_MODULES = 12  # in a folder that is not a list of kinds, one file each (it has contract.py)
CATALOGUE = ("contract.py", "table.py")  # of a folder of kinds: what each supplies, and their list
ROOM = "tolerances.py"  # of a room, with its thresholds
# Folders above that limit, and what they have: no number here may grow.
LARGE = {}
LONGEST_CHAIN = {"solver": 25, "preprocess": 24}  # of imports, file by file; may not grow either
CONSTANTS, LITERALS = 306, 152  # thresholds outside the files tolerances.py; may only fall
ANYTHING = 60  # times `dict[str, Any]`, a table of which nothing is known; may only fall
Graph = dict[str, set[str]]


@pytest.fixture(scope="module")
def structure(tools: Path) -> ModuleType:
    import structure

    return structure


@pytest.fixture(scope="module")
def graphs(structure: ModuleType, repository: Path) -> dict[str, Graph]:
    texts = structure.sources(repository)
    return {part: structure.imports(texts, part) for part in ("solver", "preprocess")}


def circle_of(graph: Graph) -> list[str]:
    """A circle of imports, empty if there is none."""
    done: set[str] = set()
    path: list[str] = []

    def visit(node: str) -> list[str]:
        if node in path:
            return [*path[path.index(node) :], node]
        if node in done:
            return []
        path.append(node)
        for target in sorted(graph.get(node, ())):
            if circle := visit(target):
                return circle
        path.pop()
        done.add(node)
        return []

    for node in sorted(graph):
        if circle := visit(node):
            return circle
    return []


def declared_layers(repository: Path) -> list[set[str]]:
    """The layers of pyproject.toml, top first."""
    with (repository / "pyproject.toml").open("rb") as file:
        contracts = tomllib.load(file)["tool"]["importlinter"]["contracts"]
    (contract,) = (c for c in contracts if c["id"] == "layers")
    assert contract["exhaustive"]
    return [{n.strip(" ()") for n in layer.split(":")} for layer in contract["layers"]]


def test_rooms_and_levels(structure: ModuleType, graphs: dict[str, Graph]) -> None:
    rooms = structure.rooms(graphs["solver"], "solver")
    assert not circle_of(rooms)
    assert len(rooms) <= MOST_ROOMS, sorted(rooms)
    assert structure.longest_chain(rooms) <= MOST_LEVELS


@pytest.mark.parametrize("part", ["solver", "preprocess"])
def test_no_circle_in_any_folder(
    part: str, structure: ModuleType, graphs: dict[str, Graph]
) -> None:
    assert not circle_of(graphs[part])
    for folder in structure.folders(graphs[part]):
        rooms = structure.rooms(graphs[part], folder)
        rooms.pop("__init__.py", None)  # what a folder offers
        circle = circle_of({room: targets - {"__init__.py"} for room, targets in rooms.items()})
        assert not circle, f"{folder}: " + " -> ".join(circle)


@pytest.mark.parametrize("part", ["solver", "preprocess"])
def test_folders_and_chains_do_not_grow(
    part: str, repository: Path, structure: ModuleType, graphs: dict[str, Graph]
) -> None:
    graph = graphs[part]
    kinds = {f for f in structure.folders(graph) if (repository / f / "contract.py").is_file()}
    sizes = {f: structure.modules_in(graph, f) for f in structure.folders(graph)}
    large = {f: n for f, n in sizes.items() if n > MOST_MODULES and f not in kinds}
    assert large == {f: n for f, n in LARGE.items() if f.split("/")[0] == part}
    assert structure.longest_chain(graph) <= LONGEST_CHAIN[part]


def test_parameters_are_documented(repository: Path, structure: ModuleType) -> None:
    known = structure.documented(structure.sources(repository) | recipe_files(repository))
    assert not [name for name, there in known.items() if not there]


def test_tables_have_types(repository: Path, structure: ModuleType) -> None:
    texts = structure.sources(repository).items()
    found = [name for name, text in texts for _ in range(text.count("dict[str, Any]"))]
    assert len(found) <= ANYTHING, found


def test_thresholds_are_in_tolerances(repository: Path, structure: ModuleType) -> None:
    texts = structure.sources(repository)
    constants, literals = structure.thresholds(texts)
    assert len(constants) <= CONSTANTS
    assert len(literals) <= LITERALS
    for name, text in texts.items():
        if name.endswith(f"/{ROOM}"):
            for named in re.findall(r"(tests/\S+\.py)::(?:\n# )?(\w+)", text):
                assert f"def {named[1]}(" in (repository / named[0]).read_text("utf-8"), named


def test_thresholds_are_found(structure: ModuleType) -> None:
    texts = {
        "a/b.py": "LEAST, MANY = 1e-9, 3\nSIZE = 2.5\ndef f(x): return x < LEAST or MANY > x",
        "a/c.py": "from .b import LEAST, SIZE\ndef f(x): return x == SIZE or x > 0.3 * LEAST",
        "a/tolerances.py": "SMALL = 1e-6\ndef f(x): return x < SMALL",
    }
    assert structure.thresholds(texts) == ({"a/b.py:LEAST"}, ["a/c.py:2"])


def test_functions_without_parameters_are_found(structure: ModuleType) -> None:
    text = """
def f(a, b, c):
    "Text.\\n\\nParameters\\n----------\\na, b, c : numbers"
def g(a, *b, c): "Text."
def _own(a, b, c): "Text."
def short(a, b): "Text."
class A:
    def h(self, a, b, **c): "Text."
    def i(self, a, b): "Text."
"""
    found = structure.documented({"x.py": text})
    assert found == {"x.py:f:2": True, "x.py:g:4": False, "x.py:h:8": False}


def test_no_arrow_runs_up(
    repository: Path, structure: ModuleType, graphs: dict[str, Graph]
) -> None:
    layers = declared_layers(repository)
    height = {name: -k for k, layer in enumerate(layers) for name in layer}
    for room, targets in structure.rooms(graphs["solver"], "solver").items():
        for target in targets - {"__init__.py"}:
            above, below = room.removesuffix(".py"), target.removesuffix(".py")
            assert height[above] >= height[below], f"{room} imports {target}"


def names_met_twice(files: Iterable[Path]) -> dict[str, list[Path]]:
    """Module names of several files, but `CATALOGUE` in folders of kinds and `ROOM` in rooms."""
    by_name: dict[str, list[Path]] = {}
    for file in sorted(files):
        in_catalogue = file.name in CATALOGUE and (file.parent / CATALOGUE[0]).is_file()
        if not file.name.startswith("__") and not in_catalogue and file.name != ROOM:
            by_name.setdefault(file.name, []).append(file)
    return {name: places for name, places in by_name.items() if len(places) > 1}


def test_no_module_name_twice_in_a_storey(repository: Path) -> None:
    solver, preprocess = repository / "solver", repository / "preprocess"
    for layer in declared_layers(repository):
        assert not names_met_twice(file for room in layer for file in (solver / room).rglob("*.py"))
    assert not names_met_twice(preprocess.rglob("*.py"))


def test_names_met_twice_are_found(tmp_path: Path) -> None:
    names = ["a/mesh.py", "b/mesh.py", "a/__init__.py", "b/__init__.py", "b/table.py"]
    names += [f"kinds/{k}/{name}" for k in "cd" for name in ("contract.py", "table.py")]
    _written(tmp_path, [(name, "") for name in names])
    assert names_met_twice(tmp_path.rglob("*.py")) == {
        "mesh.py": [tmp_path / "a" / "mesh.py", tmp_path / "b" / "mesh.py"]
    }


def test_architecture_names_every_room(repository: Path) -> None:
    page = (repository / "docs" / "architecture.md").read_text("utf-8")
    rooms = {p.name for p in (repository / "solver").iterdir() if p.is_dir()} - {"__pycache__"}
    missing = [room for room in sorted(rooms) if f"`{room}/`" not in page]
    assert not missing


def _graph(*arrows: str) -> Graph:
    graph: Graph = {name: set() for arrow in arrows for name in arrow.split(">")}
    for arrow in arrows:
        a, b = arrow.split(">")
        graph[a].add(b)
    return graph


def test_circles_and_levels_are_found(structure: ModuleType) -> None:
    straight = _graph("a>b", "b>c", "a>c")
    assert structure.longest_chain(straight) == 3
    assert circle_of(straight) == []
    assert circle_of(_graph("a>b", "b>c", "c>a")) == ["a", "b", "c", "a"]


def _written(folder: Path, files: Iterable[tuple[str, str]]) -> Path:
    for name, text in files:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


FILES = [
    ("solver/a/__init__.py", ""),
    ("solver/a/x.py", "from ..b import y\ndef f():\n    from ..b.y import Z\n"),
    ("solver/b/__init__.py", ""),
    ("solver/b/y.py", "from . import z\nimport math\nfrom ...preprocess import beam\n"),
    ("solver/b/z.py", '"""Text."""\n\n# why\nN = [\n    1,\n]\n'),
]


def test_imports_are_read(tmp_path: Path, structure: ModuleType) -> None:
    texts = structure.sources(_written(tmp_path, FILES))
    graph = structure.imports(texts, "solver")
    assert graph["solver/a/x.py"] == {"solver/b/y.py"}
    assert graph["solver/b/y.py"] == {"solver/b/z.py"}
    assert structure.rooms(graph, "solver") == {"a": {"b"}, "b": set()}
    assert structure.code_lines(texts["solver/b/z.py"]) == 3
