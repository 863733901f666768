"""Which files of other codes a command writes."""

from collections.abc import Sequence
from pathlib import Path

from ....errors import InputError
from ....package.section.io import read_section
from ..codes import OF_BLADES, OF_MESHES
from ..results import read_results
from .blades import write_beamdyn, write_hawc2
from .meshes import turning_cells, write_becas, write_vabs


def write_for(
    code: str, files: Sequence[Path], stations: Sequence[float] | None, folder: Path
) -> list[str]:
    """Write the input of another code from section files; returns lines about what was written.

    Parameters
    ----------
    code : one of TARGETS
    files : section files, those of a blade in the order of its stations
    stations : their positions along the blade [m], for OF_BLADES
    folder : where the file of a blade is written

    Raises
    ------
    InputError
        Stations that are missing or do not match the sections.
    """
    if code in OF_MESHES:
        if stations:
            raise InputError(f"--stations: expected with --to {' or '.join(OF_BLADES)} only")
        return [line for file in files for line in _mesh(code, file)]
    if stations is None or len(stations) != len(files):
        found = 0 if stations is None else len(stations)
        raise InputError(
            f"--to {code}: expected --stations with a position for each of the {len(files)} "
            f"sections, found {found}"
        )
    results = [read_results(file) for file in files]
    matrices = [r.K for r in results], [r.M for r in results]
    title = f"{len(files)} stations, {results[0].name} to {results[-1].name}"
    if code == "beamdyn":
        return [str(write_beamdyn(folder / "blade_beamdyn.dat", stations, *matrices, title=title))]
    return [str(write_hawc2(folder / "blade_hawc2_st.dat", stations, *matrices, title=title))]


def _mesh(code: str, file: Path) -> list[str]:
    section = read_section(file)
    target = file.with_suffix(".dat") if code == "vabs" else file.parent / "becas"
    made = write_vabs(section, target) if code == "vabs" else write_becas(section, target)
    turning = turning_cells(section)
    if not turning:
        return [str(made)]
    return [
        str(made),
        f"{made}: in {turning} cells the layer direction or the ply changes; the file has that of "
        "their middle",
    ]
