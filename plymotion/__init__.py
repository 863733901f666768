"""Flexible multibody dynamics with laminated composite members.

Two halves meet in one file: `plymotion.preprocess` (FEniCSx) writes a modal
package per body, `plymotion.solver` (NumPy) reads packages and integrates the
mechanism. See docs/adr/0001 for the two links in this folder.
"""

from pathlib import Path

__version__ = "0.1.0"

# A checkout without symlinks (Windows) has text files where the links should
# be: look for the halves beside this folder instead.
_root = Path(__file__).resolve().parent
if not (_root / "solver").is_dir():
    __path__.append(str(_root.parent))
