"""The commands on modal packages: packages, info, import, export."""

import argparse
import math
import sys
from contextlib import suppress
from pathlib import Path

from ...errors import InputError, PackageError, counted, few, printable
from ...extras.exchange import export_body, import_body
from ...package import ModalPackage, validate
from ...package.body.package_file import read_package
from ...report.table import rounded
from ...studies.cases import build_folder, chosen_run
from ...studies.exit_codes import INCOMPLETE
from ...studies.fmu import VERSIONS
from ...workers.executors import executor_of
from ...workers.packages import BodiesFailed, build_packages, named_packages, needed_specs, prepared


def run_packages(options: argparse.Namespace) -> int:
    """Build the packages of run and sweep files; return 0, or 3 if a body could not be built."""
    code = 0
    named = {file: named_packages(file) for file in options.files}
    for folder, specs in needed_specs(named).items():
        try:
            build_packages(
                specs,
                folder,
                executor=lambda: executor_of(options, threads=True),
            )
        except BodiesFailed as error:
            print(f"error: {error}", file=sys.stderr)
            code = INCOMPLETE
    return code


def run_info(options: argparse.Namespace) -> int:
    """Check packages and section files, and show packages; return 2 if one has errors."""
    failed = 0
    for path in options.files:
        findings = validate(path)
        for item in findings:
            print(f"{path}: {item.level}: {item.dataset}: {item.message}")
        if any(item.level == "error" for item in findings):
            failed = 2
            continue
        print(f"{path}: valid")
        with suppress(PackageError):  # a section file, which `section` shows
            _show(read_package(path))
    return failed


def _show(package: ModalPackage) -> None:
    """Print the content of a package."""
    print(f"{package.body}: {package.nodes_B.shape[0]} nodes, {package.n_mode} modes")
    print(f"  reference condition {package.reference_condition}")
    print(f"  mass {package.invariants.mass:.6g} kg, inertia {package.invariants.mass_form}")
    labels = package.mode_labels or package.mode_kinds
    for label, frequency in zip(labels, package.frequencies, strict=True):
        print(f"  {label:24s} {frequency:12.5g} rad/s {frequency / (2.0 * math.pi):12.5g} Hz")
    size = float(abs(package.nodes_B).max())
    for interface in package.interfaces:
        at = ", ".join(rounded(x, size, 6) for x in interface.position_B.tolist())
        print(f"  interface {interface.name:12s} at ({at}) m")
    for one in package.design:
        targets = few(str(target.get("of")) for target in one.targets)
        print(f"  derivatives by {one.name} ({one.kind}): {len(one.values)} datasets; {targets}")


def run_import(options: argparse.Namespace) -> int:
    """Run `plymotion import`; returns the exit code."""
    if options.file.suffix == ".urdf":
        return import_urdf(options)
    out = options.out or Path(f"{options.file.stem}.vtkhdf")
    return _shown(*import_body(options.file, out, options.source, quiet=options.quiet))


def import_urdf(options: argparse.Namespace) -> int:
    """Write the case of a robot; return the exit code."""
    from ...extras.robot.case_folder import import_robot

    out = options.out or Path(options.file.stem)
    made = import_robot(
        options.file,
        out,
        joints=options.joints,
        base=options.base,
        keep_fixed=options.keep_fixed,
        meshes=not options.no_meshes,
        packages=dict(options.package),
        allow=options.allow,
    )
    for note in made.notes:
        print(f"note: {printable(note)}", file=sys.stderr)
    counts = [
        counted(len(made.tables[group]), one, group)
        for group, one in (("bodies", "body"), ("joints", "joint"), ("couplings", "coupling"))
        if made.tables.get(group)
    ]
    print(f"{out / 'case.toml'}: {', '.join(counts)}")
    if options.joints == "hold":
        print("Drives hold the joints at 0. Give them a motion, such as this one [rad]:")
        print("drive = { smooth_step = { value = 1.0, duration = 1.0 } }")
    return 0


def run_export(options: argparse.Namespace) -> int:
    """Run `plymotion export`; returns the exit code."""
    if options.target in VERSIONS:
        return export_fmu(options)
    for name in ("run", "inputs", "coarse", "packages"):
        if getattr(options, name):
            raise InputError(f"--{name}: expected with --to fmu or fmu3 only")
    return _shown(*export_body(options.file, options.target, options.out))


def _shown(code: int, text: str) -> int:
    if text:
        print(text, file=sys.stderr if code else sys.stdout)
    return code


def export_fmu(options: argparse.Namespace) -> int:
    """Write a run of a case as an FMU; return the exit code."""
    from ...inputs.case.load import load_case
    from ...studies.fmu.write import write_fmu  # these take 0.2 s to import

    file: Path = options.file
    if file.suffix != ".toml":
        raise InputError(f"{file}: expected a case file, CASE.toml, with --to {options.target}")
    case = load_case(file, coarse=options.coarse, sweeps=())
    run = chosen_run(case, options.run, only=True)
    folder = build_folder(file, coarse=options.coarse)
    run_file = prepared(case, folder, f"runs/{run}.json", options.packages)
    out: Path = options.out or folder / f"{run}.fmu"
    stepper = write_fmu(run_file, out, options.inputs, options.target)
    for name in stepper.left_out:
        print(f"signals.{name}: no output: it is known at the end of a run only")
    print(f"{out}: {len(stepper.inputs)} inputs, {len(stepper.outputs)} outputs")
    return 0
