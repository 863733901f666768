"""The descriptions of cases/shells: all are accepted, and between them they use every mesh."""

import json
from pathlib import Path

from plymotion.solver.__main__ import main

ROOT = Path(__file__).resolve().parent.parent.parent
CASES = sorted((ROOT / "cases" / "shells").glob("*.toml"))
SCRIPTS = sorted(path for path in (ROOT / "meshes" / "shells").glob("*.py") if path.stem != "grid")


def test_descriptions_are_accepted(tmp_path: Path) -> None:
    assert main(["shell", *map(str, CASES), "--check", "--out", str(tmp_path)]) == 0
    for case in CASES:
        file = tmp_path / case.stem / f"{case.stem}.json"
        assert Path(json.loads(file.read_text(encoding="utf-8"))["mesh"]["file"]).is_file()


def test_every_mesh_has_a_case() -> None:
    assert len(CASES) == 14
    for script in SCRIPTS:
        assert any(f"/{script.name}" in case.read_text() for case in CASES), script.name
