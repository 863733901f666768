"""The sweeps that benchmarks/scale.py measures: double pendulums of two parameters, two signals."""

from pathlib import Path

from processes import Cost, cost

PLYMOTION = ("-m", "plymotion")
CASE = Path("cases/double-pendulum/case.toml")
PACKAGES = Path("tests/packages/double-pendulum")
# The case up to its variants, and this.
TEXT = """
[variants.measured.solver]
t_end = {t_end}
output_step = 0.001
rtol = 1e-5
[coarse.sweeps.s]
count = 2
[sweeps.s]
run = "isotropic"
variants = ["measured"]
design = "latin-hypercube"
count = {count}
signals = ["tip_x", "hand_mid"]
[sweeps.s.vary]
"masses.M2.mass" = {{ from = 1.0, to = 4.0 }}
"joints.shoulder.drive.speed" = {{ from = 5.0, to = 20.0 }}
"""


def checked(folder: Path, count: int, t_end: float = 1.0) -> tuple[Path, Cost]:
    """Check the case of a sweep of so many members; its sweep file, and what the check took."""
    folder.mkdir(parents=True, exist_ok=True)
    text = CASE.read_text(encoding="utf-8")
    text = text[: text.index("[variants.fifth.solver]")] + TEXT.format(count=count, t_end=t_end)
    case, out = folder / "case.toml", folder / "build"
    case.write_text(text, encoding="utf-8")
    used = cost([*PLYMOTION, "check", str(case), "--out", str(out), "--packages", str(PACKAGES)])
    return out / "sweeps/s.json", used


def sweep(file: Path, out: Path, *words: str) -> list[str]:
    """Return the arguments of Python for a sweep."""
    more = ("--quiet", "--no-figures", "--out", str(out))
    return [*PLYMOTION, "sweep", str(file), *more, *words]
