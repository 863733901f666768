"""Arguments of the commands that work on sections, shells, solids, blades and packages."""

import argparse
import math
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import InputError, did_you_mean
from ..package.section.codes import CODES, OF_BLADES, TARGETS
from ..studies.fmu import VERSIONS
from ..studies.modes.place import at_of
from .arguments import (
    FOLDERS,
    add,
    add_case_options,
    add_executor,
    add_no_scripts,
    command,
    expecting,
    flag,
    number,
    numbers,
    shard,
    whole_number,
)

# Without --out None: a folder that the user has named may be a link.
FORMATS = Path(__file__).parents[2] / "preprocess/exchange/formats"  # a file each
PACKAGE = "PACKAGE.vtkhdf"


_accuracy = expecting(number, lambda a: 0.0 < a < 1.0, "a number from 0 to 1, such as 1e-3")
_distance = expecting(number, lambda d: 0.0 < d < math.inf, "a length above 0 [m]")
_positions = expecting(numbers, bool, "numbers with commas [m]")
_loads = expecting(
    numbers, lambda F: len(F) == 6, "six numbers with commas, F1,F2,F3,M1,M2,M3 [N, N m]"
)
_places = expecting(
    numbers,
    lambda r: bool(r) and r == sorted({*r}) and r[0] >= 0.0 and r[-1] <= 1.0,
    "rising numbers from 0 to 1",
)


@command("section", "bodies.section:run_section")
def add_section(parser: Any) -> None:
    """Analyse beam cross-sections.

    Stiffness, mass, centres and stresses of beam cross-sections. FILE is a description (TOML,
    docs/section-description.md), an input file of VABS (.dat, .sg), a folder of BECAS input, or a
    section file (.vtkhdf) to show again. It runs in the Python with FEniCSx:
    $FENICSX_PYTHON, the one that `make fenicsx` found, python3 or /usr/bin/python3.

    ---

    Writes DIR/<name>/<name>.vtkhdf, a section file with mesh, plies, warping and stress recovery
    that ParaView opens, and figures beside it. Files made from the same description, options and
    sources are not made again, so an interrupted batch continues where it stopped.

    A batch (LIST) is a folder of descriptions, a pattern in quotes, a text file with one
    description per line, or a study in TOML: `sections` to vary and [[sweep]] tables of a key and
    its values (or a CSV file with a row of numbers for each). It writes DIR/summary.csv and .json.

    K relates [F1 F2 F3 M1 M2 M3] to [extension, shear 2, shear 3, twist, bending 2, bending 3] at
    the origin of the description; --order gives it in the order of other codes
    (docs/conventions.md).

    exit code: 0 done; 2 wrong input, the other sections of a batch are made; 130 interrupted,
    complete files are kept.
    """
    add_no_scripts(parser)
    what = parser.add_argument_group("what to make")
    what.add_argument("files", nargs="*", type=Path, metavar="FILE", help="section description")
    what.add_argument("--batch", metavar="LIST", help="analyse many sections, see below")
    add(what, "--shard", "k/N", "only the k-th of N shares of LIST", shard)
    text = "refine until the estimated error of K, scaled by sqrt(Kii Kjj), is below A"
    what.add_argument("--accuracy", type=_accuracy, metavar="A", help=text)
    flag(what, "no-estimate", "skip the error estimate (faster)")
    flag(what, "verify", "compute K by a second method as well, and compare")
    text = (
        "also the exact derivatives of K, M, centres and stresses by numbers of the description: "
    )
    text += "dotted keys of angles, thicknesses, sizes, constants of materials"
    what.add_argument("--derivatives", nargs="+", default=[], metavar="KEY", help=text)
    _add_figures(what, "draw figures (default: for FILE without --json)")
    _add_described(what, "force", "check")
    text = (
        "also write the input of another code: vabs and becas for each section, beamdyn and hawc2 "
    )
    text += "for the stations of a blade"
    what.add_argument("--to", choices=TARGETS, help=text)
    text = "with --to beamdyn or hawc2: position of each FILE along the blade [m]"
    what.add_argument("--stations", type=_positions, metavar="R1,R2,...", help=text)
    how = parser.add_argument_group("how and where")
    _add_out(how, "section")
    add_executor(how, "sections")
    _add_described(how, "quiet")
    shown = parser.add_argument_group("what to show")
    _add_described(shown, "json")
    text = f"order and signs of K and M: {', '.join(CODES)}"
    shown.add_argument("--order", type=_code, default="plymotion", metavar="CODE", help=text)
    text = "also the stresses and margins of every ply under these resultants [N, N m]; write "
    text += "--loads=-1,... if the first is negative"
    shown.add_argument("--loads", type=_loads, metavar="F1,F2,F3,M1,M2,M3", help=text)
    text = (
        "with --loads: leave out points nearer than D [m] to a re-entrant corner, where stresses "
    )
    text += "depend on the mesh"
    shown.add_argument("--corner-distance", type=_distance, metavar="D", help=text)


@command("shell", "bodies.shell:run_shell")
def add_shell(parser: Any) -> None:
    """Load cases and frequencies of laminated shells.

    Deflections, reactions, ply stresses and natural frequencies of laminated plates and shells.
    FILE is a description (TOML, docs/shell-description.md), or a shell file (.vtkhdf) to show
    again. It runs in the Python with FEniCSx: $FENICSX_PYTHON, the one that `make fenicsx` found,
    python3 or /usr/bin/python3.

    ---

    Writes DIR/<name>/<name>.vtkhdf, a shell file with mesh, laminates, displacements, resultants
    and modes that ParaView opens, and figures beside it. Files made from the same description and
    sources are not made again.

    exit code: 0 done; 2 wrong input, the other FILEs are made; 130 interrupted, complete files are
    kept.
    """
    add_no_scripts(parser)
    add(parser, "files", "FILE", "shell description or shell file", nargs="+")
    _add_out(parser, "shell")
    _add_described(parser, "check", "json")
    _add_figures(parser, "draw deflected shapes and modes (default: without --json)")
    text = "load factors of linear buckling of every load case (default 4 of each), with their "
    text += (
        "errors by the mesh: a mesh of half the cell size, which doubles to quadruples the time "
    )
    text += "of this step; error = false in [buckling] leaves it out"
    kept: dict[str, object] = {"nargs": "?", "const": 4, "metavar": "COUNT"}
    parser.add_argument("--buckling", type=whole_number, help=text, **kept)
    text = "bound of the lowest frequency, load factor or compliance over all angles of the plies, "
    text += "and a lay-up near it; with one load case"
    parser.add_argument("--bound", choices=("frequency", "buckling", "compliance"), help=text)
    text = "compute strain energies and frequencies by a second method as well, and compare"
    flag(parser, "verify", text)
    _add_described(parser, "force", "quiet")
    add_executor(parser, "shells")


@command("solid", "bodies.shell:run_solid")
def add_solid(parser: Any) -> None:
    """Inertia, frequencies and load cases of solids from CAD.

    Mass, inertia, natural frequencies and load cases of solids. FILE is a CAD file (STEP, IGES), a
    description (TOML, docs/solids.md), or a package that this command made (.vtkhdf) to show again.
    It runs in the Python with FEniCSx: $FENICSX_PYTHON, the one that `make fenicsx` found, python3
    or /usr/bin/python3.

    ---

    Writes DIR/<name>/<name>.vtkhdf, the modal package of the free solid: ParaView opens it, and a
    case takes it with kind = "package". Files made from the same description and sources are not
    made again.

    exit code: 0 done; 2 wrong input, the other FILEs are made; 130 interrupted, complete files are
    kept.
    """
    add_no_scripts(parser)
    add(parser, "files", "FILE", "CAD file, description or package", nargs="+")
    text = "of a CAD file: aluminium, steel, titanium, or constants in Pa and kg/m3"
    parser.add_argument("--material", metavar="NAME|E,nu,rho", help=text)
    add(parser, "--size", "M", "of the cells [m] (default: see docs/solids.md)", float)
    _add_out(parser, "solid")
    _add_described(parser, "check", "json", "force", "quiet")
    add_executor(parser, "solids")


@command("blade", "bodies.blade:run_blade")
def add_blade(parser: Any) -> None:
    """Cross-sections of a rotor blade from a windIO file.

    Cross-sections of a rotor blade: stiffness and mass matrices of its stations from a windIO 2
    file. The shell is meshed layer by layer to the thickness of the file, with its reinforcements,
    sandwich panels, spar caps and webs.

    ---

    Writes in DIR:
      stations/  a mesh and a section description of each station (docs/section-description.md)
      sections/  a section file of each station (.vtkhdf), and summary.csv
      blade.csv  span, chord, twist, 6x6 stiffness and mass of each station
      beam.csv   the blade as a body of a case: kind = "beam", table = "beam.csv"
      case.toml  this body on its turning hub: plymotion modes DIR/case.toml --at spin=...
      blade_*    with --to: stiffness, mass and geometry for another code
      rotor.toml with --rotor: the turbine in the wind as a case, with its controller; tower.csv,
                 aero.csv, polars.csv (tower, strips, polars) and operation.csv (speed, pitch, power
                 and thrust over the wind with rigid blades)
      with --spin: frequencies.csv (at rest, with estimated errors), campbell.csv, .json and .png

    Axes of a section: x2 from the reference axis to the leading edge along the chord, x3 to the
    suction side, x1 to the tip. The matrices are about the reference axis, without twist. Stations
    that are up to date are not analysed again, so an interrupted command continues where it
    stopped.

    exit code: 0 done; 2 wrong input, or a station that cannot be analysed (the others are); 130
    interrupted, complete files are kept.

    example:
      plymotion blade IEA-15-240-RWT.yaml --stations 50 --to beamdyn --spin 0:0.8:0.1 -o blade
    """
    add(parser, "file", "FILE", "turbine file of windIO 2 (.yaml)")
    text = "equal distances from root to tip (default: the grid of the file's chord)"
    count = partial(whole_number, least=2)
    parser.add_argument("--stations", type=count, metavar="N", help=text)
    add(parser, "--at", "R,R,...", "these stations, 0 at the root, 1 at the tip", _places)
    add(parser, "--out -o", "DIR", "folder (default build/blades/NAME)")
    add(parser, "--to", "CODE", "also files for beamdyn or hawc2", str, choices=OF_BLADES)
    text = "also frequencies over the speed of the rotor [rad/s], or rpm: 0:12:1rpm"
    parser.add_argument("--spin", type=_speeds, metavar="FIRST:LAST:STEP", help=text)
    add(parser, "--jobs", "N", "stations at a time (default 1)", whole_number, default=1)
    text = "also the case of the turbine in the wind, and its steady operation (docs/rotor.md)"
    flag(parser, "rotor", text)
    text = "with --rotor: a library with Bladed's interface and its input file, such as ROSCO's"
    names = ("LIBRARY", "INPUT")
    parser.add_argument("--controller", type=Path, nargs=2, metavar=names, help=text)
    flag(parser, "no-estimate", "skip the error estimate")
    flag(parser, "check", "write meshes and descriptions of the stations only")
    flag(parser, "quiet", "no progress")


@command("import", "bodies.packages:run_import")
def add_import(parser: Any) -> None:
    """Make a package from a body of another code or measured modes, or a case from a robot (URDF).

    Make a modal package from a body of another code. FILE (TOML, docs/exchange.md) names the files,
    their units, the interfaces and the modes. With --from measured, FILE has nodes, modes and
    places of a test (docs/modes.md). A FILE.urdf becomes a folder with case.toml and meshes of the
    links for pictures (docs/robots.md).

    ---
    """
    parser.add_argument("file", type=Path, metavar="FILE", help="import file, TOML; or a URDF")
    text = "the other code, or measured (default: the key `from` of FILE)"
    parser.add_argument("--from", dest="source", metavar="CODE", help=text)
    text = f"{PACKAGE}; of a robot the new folder (default: named like FILE, in the current folder)"
    parser.add_argument("--out", "-o", type=Path, metavar="PACKAGE", help=text)
    flag(parser, "quiet", "no progress")
    robot = parser.add_argument_group("of a robot")
    text = "hold: drives hold all joints (default); motor: an actuator in each; free: neither"
    robot.add_argument("--joints", choices=["hold", "motor", "free"], default="hold", help=text)
    text = "whether the root link is the ground (default), or a body that moves freely"
    robot.add_argument("--base", choices=["fixed", "free"], default="fixed", help=text)
    flag(robot, "keep-fixed", "links on fixed joints stay bodies if they have a mass")
    flag(robot, "no-meshes", "no pictures of the links")
    text = "folder of a ROS package (default: one of its name above FILE); may be repeated"
    robot.add_argument(
        "--package", action="append", default=[], type=_package, metavar="NAME=PATH", help=text
    )
    text = "accept inertia that no solid has, or sizes that suggest wrong units"
    robot.add_argument(
        "--allow", action="append", default=[], choices=["inertia", "units"], help=text
    )


def _package(text: str) -> tuple[str, Path]:
    name, equals, path = text.partition("=")
    if not (name and equals and path):
        raise argparse.ArgumentTypeError(f"{text}: expected NAME=PATH")
    return name, Path(path)


def written_formats() -> list[str]:
    """Return the formats of `export`: files that write one. The solver does not import them."""
    files = sorted(FORMATS.glob("*.py"))
    return [*(f.stem for f in files if "\ndef write(" in f.read_text("utf-8")), *VERSIONS]


@command("export", "bodies.packages:run_export")
def add_export(parser: Any) -> None:
    """Write a modal package in the format of another code, or a run as an FMU.

    Write a modal package in the format of another code: exudyn (a script that adds the body),
    mujoco (a chain of virtual joints), uff (modes and masses), med (mesh and shapes), dmig (NASTRAN
    bulk data), mbdyn (.fem of the modal joint), sid (standard input data). Or write a run of a case
    as an FMU for co-simulation: fmu (FMI 2.0), fmu3 (FMI 3.0).

    ---
    """
    add(parser, "file", "FILE", "PACKAGE.vtkhdf; with --to fmu or fmu3 CASE.toml")
    parser.add_argument(
        "--to", dest="target", required=True, choices=written_formats(), help="the format"
    )
    text = "the new file (default: beside the package; of an FMU build/CASE/RUN.fmu)"
    parser.add_argument("--out", "-o", type=Path, metavar="FILE", help=text)
    fmu = parser.add_argument_group("with --to fmu or fmu3")
    fmu.add_argument("--run", metavar="NAME", help="the run (default: the only one of the case)")
    text = (
        "drives and forces that are inputs, such as joints.hinge.drive (default: all); the others "
    )
    text += "follow their laws in the case"
    fmu.add_argument("--inputs", nargs="*", metavar="KEY", help=text)
    add_case_options(fmu)


@command("info", "bodies.packages:run_info")
def add_info(parser: Any) -> None:
    """Check modal packages and section files against docs/format.md, and show packages."""
    add(parser, "files", "FILE", f"{PACKAGE} or a section file", nargs="+")


_DESCRIBED = {
    "check": "check descriptions, write DIR/<name>/<name>.json only",
    "json": "numbers as JSON on standard output",
    "force": "repeat also what has not changed",
    "quiet": "no progress",
}


def _add_described(group: Any, *names: str) -> None:
    """Add options that sections, shells and solids share."""
    for name in names:
        flag(group, name, _DESCRIBED[name])


def _add_figures(group: Any, text: str) -> None:
    group.add_argument("--figures", action=argparse.BooleanOptionalAction, help=text)


def _add_out(group: Any, name: str) -> None:
    add(group, "--out", "DIR", f"folder (default {FOLDERS[name]})")


def _code(text: str) -> str:
    code = {"anba": "anba4"}.get(text, text)
    if code not in CODES:
        hint = did_you_mean(code, CODES)
        raise argparse.ArgumentTypeError(f"{text!r}: expected one of {', '.join(CODES)}{hint}")
    return code


def _speeds(text: str) -> str:
    """The text as it is, if `plymotion modes --at spin=` can read it."""
    try:
        at_of(f"spin={text}")
    except InputError as error:
        reason = str(error).rpartition("; ")[0] or str(error)
        raise argparse.ArgumentTypeError(reason.removeprefix("--at spin=")) from error
    return text
