"""An import of 100,000 degrees of freedom: processor time and memory of `plymotion import`.

    PYTHONPATH=.:tests .venv/bin/python benchmarks/exchange_size.py [FOLDER]

A bar of trilinear bricks with consistent mass, 101,907 degrees of freedom, 20 vibrations and 6
static shapes, from Matrix Market files. It prints the CPU seconds and the largest memory of the
command as its user starts it.
"""

import resource
import subprocess
import sys
from pathlib import Path

import scipy.io
from samples.brick_model import brick

COUNT, SIZE, DENSITY = (200, 12, 12), (2.0, 0.12, 0.12), 2700.0
IMPORT_FILE = f"""\
format = 1
body = "bar"
from = "matrices"
units = {{ length = "m", mass = "kg", time = "s" }}
total_mass = {DENSITY * SIZE[0] * SIZE[1] * SIZE[2]!r}
reference = {{ kind = "clamped", at = "root" }}
modes = [
    {{ kind = "lowest", count = 20 }},
    {{ kind = "attachment", at = "tip", directions = ["x", "y", "z", "rx", "ry", "rz"] }},
]

[files]
stiffness = "K.mtx"
mass = "M.mtx"
nodes = "nodes.csv"
dofs = "dofs.csv"

[interfaces]
root = {{ box = [[-1e-6, -1.0, -1.0], [1e-6, 1.0, 1.0]], link = "rigid" }}
tip = {{ box = [[{SIZE[0] - 1e-6}, -1.0, -1.0], [{SIZE[0] + 1e-6}, 1.0, 1.0]], link = "rigid" }}
"""


def write(folder: Path) -> None:
    """The files of the bar."""
    folder.mkdir(parents=True, exist_ok=True)
    body = brick(SIZE, COUNT, density=DENSITY)
    body.M.eliminate_zeros()
    for name, A in (("K", body.K), ("M", body.M)):
        scipy.io.mmwrite(folder / f"{name}.mtx", A, symmetry="symmetric", precision=17)
    lines = [f"{i},{x!r},{y!r},{z!r}" for i, (x, y, z) in enumerate(body.nodes.tolist(), 1)]
    (folder / "nodes.csv").write_text("\n".join(lines) + "\n")
    dofs = [f"{node},{direction}" for node, direction in body.dofs]
    (folder / "dofs.csv").write_text("\n".join(dofs) + "\n")
    (folder / "bar.toml").write_text(IMPORT_FILE)


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "build/exchange-size")
    if not (folder / "bar.toml").is_file():
        subprocess.run([sys.executable, __file__, "write", str(folder)], check=True)
    command = [sys.executable, "-m", "plymotion", "import", str(folder / "bar.toml")]
    subprocess.run([*command, "-o", str(folder / "bar.vtkhdf")], check=True)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{used.ru_utime + used.ru_stime:.1f} CPU s, {used.ru_maxrss / 1e6:.2f} GB")


if __name__ == "__main__":
    if sys.argv[1:2] == ["write"]:
        write(Path(sys.argv[2]))
    else:
        main()
