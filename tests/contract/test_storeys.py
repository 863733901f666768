"""Rooms of solver/ and the direction of their imports, computed from the source.

The rooms are described in docs/architecture.md.
"""

import ast
import tomllib
from collections import defaultdict
from collections.abc import Iterable
from functools import cache
from pathlib import Path

MOST_ROOMS, MOST_LEVELS = 20, 10
Graph = dict[str, set[str]]


@cache
def imports(solver: Path) -> Graph:
    """File -> files of solver/ that it imports, wherever the import statement stands."""
    files = {path.relative_to(solver).as_posix(): path for path in solver.rglob("*.py")}
    modules = {}
    for name in files:
        module = name.removesuffix(".py").removesuffix("__init__").rstrip("/").replace("/", ".")
        modules[module] = name
    graph: Graph = {name: set() for name in files}
    for name, path in files.items():
        package = Path(name).parent.parts
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if not isinstance(node, ast.ImportFrom):
                continue
            if node.level:
                if node.level > len(package) + 1:
                    continue  # plymotion itself
                base = package[: len(package) - node.level + 1]
                module = ".".join((*base, *([node.module] if node.module else [])))
            elif node.module and node.module.startswith("plymotion.solver"):
                module = node.module.removeprefix("plymotion.solver").lstrip(".")
            else:
                continue
            for alias in node.names:
                inner = f"{module}.{alias.name}".lstrip(".")
                target = modules.get(inner, modules.get(module))
                if target and target != name:
                    graph[name].add(target)
    return graph


def rooms_of(graph: Graph) -> Graph:
    """The same between folders and files directly under solver/."""
    rooms: Graph = defaultdict(set)
    for name, targets in graph.items():
        room = name.split("/")[0]
        rooms[room] |= {target.split("/")[0] for target in targets} - {room}
    return dict(rooms)


def levels(graph: Graph) -> tuple[dict[str, int], list[str]]:
    """Longest chain of imports below each node, and a circle (empty if there is none)."""
    found: dict[str, int] = {}
    path: list[str] = []

    def visit(node: str) -> list[str]:
        if node in path:
            return [*path[path.index(node) :], node]
        if node in found:
            return []
        path.append(node)
        for target in sorted(graph.get(node, ())):
            if circle := visit(target):
                return circle
        path.pop()
        found[node] = 1 + max((found[t] for t in graph.get(node, ())), default=0)
        return []

    for node in sorted(graph):
        if circle := visit(node):
            return found, circle
    return found, []


def declared_layers(repository: Path) -> list[set[str]]:
    """The layers of pyproject.toml, top first."""
    with (repository / "pyproject.toml").open("rb") as file:
        contracts = tomllib.load(file)["tool"]["importlinter"]["contracts"]
    (contract,) = (c for c in contracts if c["id"] == "layers")
    assert contract["exhaustive"]
    return [{n.strip(" ()") for n in layer.split(":")} for layer in contract["layers"]]


def test_rooms_levels_and_circles(repository: Path) -> None:
    graph = imports(repository / "solver")
    _, circle = levels(graph)
    assert not circle, "files import each other: " + " -> ".join(circle)
    rooms = rooms_of(graph)
    level, circle = levels(rooms)
    assert not circle, "rooms import each other: " + " -> ".join(circle)
    assert len(rooms) <= MOST_ROOMS, sorted(rooms)
    assert max(level.values()) <= MOST_LEVELS, level


def test_no_arrow_runs_up(repository: Path) -> None:
    layers = declared_layers(repository)
    height = {name: -k for k, layer in enumerate(layers) for name in layer}
    for room, targets in rooms_of(imports(repository / "solver")).items():
        for target in targets - {"__init__.py"}:
            above, below = room.removesuffix(".py"), target.removesuffix(".py")
            assert height[above] >= height[below], f"{room} imports {target}"


def test_architecture_names_every_room(repository: Path) -> None:
    page = (repository / "docs" / "architecture.md").read_text("utf-8")
    rooms = {p.name for p in (repository / "solver").iterdir() if p.is_dir()} - {"__pycache__"}
    missing = [room for room in sorted(rooms) if f"`{room}/`" not in page]
    assert not missing


def _graph(*arrows: str) -> Graph:
    graph: Graph = defaultdict(set)
    for arrow in arrows:
        a, b = arrow.split(">")
        graph[a].add(b)
        graph[b] |= set()
    return dict(graph)


def test_circles_and_levels_are_found() -> None:
    level, circle = levels(_graph("a>b", "b>c", "a>c"))
    assert level == {"a": 3, "b": 2, "c": 1}
    assert circle == []
    assert levels(_graph("a>b", "b>c", "c>a"))[1] == ["a", "b", "c", "a"]


def _write(folder: Path, files: Iterable[tuple[str, str]]) -> Path:
    for name, text in files:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def test_imports_are_read(tmp_path: Path) -> None:
    files = [
        ("a/__init__.py", ""),
        ("a/x.py", "from ..b import y\ndef f():\n    from ..b.y import Z\n"),
        ("b/__init__.py", ""),
        ("b/y.py", "from . import z\nimport math\nfrom ...preprocess import beam\n"),
        ("b/z.py", ""),
    ]
    graph = imports(_write(tmp_path, files))
    assert graph["a/x.py"] == {"b/y.py"}
    assert graph["b/y.py"] == {"b/z.py"}
    assert rooms_of(graph) == {"a": {"b"}, "b": set()}
