"""Frequencies of the 30 deg strip by beam theory and as a solid (docs/adr/0006), with FEniCSx:

. build/fenicsx.env && PYTHONPATH=. "$FENICSX_PYTHON" benchmarks/strip_theories.py
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from peers.strip_models import beam, clamped_hz, free_hz, solid


def main() -> None:
    print("all frequencies [Hz]; the clamped list has bending in the plane of the strip second")
    models = {"beam, full 6x6": beam("timoshenko"), "beam, no shear": beam("classical")}
    for name, (K, M, free) in {**models, "solid": solid()}.items():
        print(f"{name:15s} clamped", clamped_hz(K, M, free, 4).round(2), end="  ")
        print("free", free_hz(K, M, 2).round(2))


if __name__ == "__main__":
    main()
