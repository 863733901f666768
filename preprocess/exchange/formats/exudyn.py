"""Package to Exudyn: a script that reads the package and adds the body to a mechanism."""

from pathlib import Path

from ....solver.package import ModalPackage
from ....solver.package.common.files import write_text

SUFFIX = ".py"
SCRIPT = Path(__file__).with_name("exudyn_body.py")


def write(package: ModalPackage, out: Path, source: Path) -> str:
    """Write the script; return a remark.

    Parameters
    ----------
    package, out : see contract.py
    source : file that the script reads, which must stay beside it
    """
    relative = source.resolve()
    name = relative.name if relative.parent == out.resolve().parent else str(relative)
    text = SCRIPT.read_text(encoding="utf-8").replace('"PACKAGE"', repr(name))
    if out.stem.isidentifier():  # others cannot be imported by name
        text = text.replace("arm_exudyn", out.stem)
    write_text(out, text)
    return f"{package.n_mode} modes; import it beside {name}"
