"""Read a case file: merge variants, check every run, resolve names."""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any, get_args

from pydantic import ValidationError

from ...errors import InputError, did_you_mean, printable, refuse, unknown
from ..common.input_table import bare_lines, meant, members, validated, without_annotations
from ..common.text_file import Tables, read_toml
from ..section.description import shape
from .bodies.specifications import BodySpec, BodySpecs
from .checks import check_elsewhere, in_parts
from .design import Case, CheckedStudy, check_study
from .expressions import drives, law
from .messages import Findings
from .record import case_name
from .sweeps import CheckedSweep, MergedOf, check_sweep, unit_at
from .tables.schema import CaseFile, Mechanism, Sweep, mechanism_of


def merge(base: Tables, over: Tables, way: tuple[str, ...] = ()) -> None:
    """Merge tables of `over` into `base` in place; values and lists are replaced.

    A table of a mechanism whose kind changes keeps the keys that both kinds have.

    Parameters
    ----------
    base : tables that are changed
    over : tables with the new values
    way : keys from the case to `base`
    """
    for key, value in over.items():
        if isinstance(value, dict) and isinstance(base.get(key), dict):
            if len(way) == 1:
                _forget(way[0], base[key], value)
            merge(base[key], value, (*way, key))
        else:
            base[key] = deepcopy(value)


def _forget(group: str, table: Tables, over: Tables) -> None:
    """Remove from a table of `group` what the kind that `over` gives it does not have."""
    known = _keys(group)
    old, new = _kind(group, table), _kind(group, over)
    named = isinstance(old, str) and isinstance(new, str)  # a kind may be anything in a bad file
    if not named or old == new or old not in known or new not in known:
        return
    for key in list(table):
        if known[old].get(key, old) != known[new].get(key, new):
            del table[key]


def _kind(group: str, table: Tables) -> Any:
    return shape(table) if group == "sections" else table.get("kind")


@cache
def _keys(group: str) -> dict[Any, dict[str, object]]:
    """Return the keys of every kind of a group with their types; empty for a group without."""
    field = Mechanism.model_fields.get(group)
    arguments = () if field is None else get_args(field.annotation)
    if len(arguments) != 2:
        return {}
    return {
        kind: {f.alias or name: f.annotation for name, f in model.model_fields.items()}
        for kind, model in members(without_annotations(arguments[-1])).items()
    }


# Names that the folder of a case has for other things than the results of a run, or of a sweep.
RESERVED = {
    "runs": {
        "bodies": "a folder of this name",
        "runs": "a folder of this name",
        "sweeps": "a folder of this name",
        "studies": "a folder of this name",
    },
    "sweeps": {"bodies": "a folder sweeps/bodies"},
}


_APART = ("sweeps", "design")  # of [coarse]: not keys of a mechanism


def load_case(file: Path, *, coarse: bool = False, sweeps: Collection[str] | None = None) -> Case:
    """Read and check a case file.

    Parameters
    ----------
    coarse : the coarse version of the case
    sweeps : names of the sweeps whose members are made and checked; None: all. A sweep of 10 000
        members takes some seconds, which a single run need not wait for.

    Raises
    ------
    InputError
        One line per error: file, key, value, expectation.
    """
    return checked_case(read_toml(file, "case file"), file, coarse=coarse, sweeps=sweeps)


def load_whole_case(file: Path) -> Case:
    """Read and check a case file with all sweeps, and its coarse version. Raises InputError."""
    table = read_toml(file, "case file")
    cases, errors = list[Case](), list[str]()
    for coarse in (False, True) if table.get("coarse") else (False,):
        try:
            cases.append(checked_case(table, file, coarse=coarse))
        except InputError as error:
            new = [line for line in str(error).splitlines() if line not in errors]
            errors += [f"{line} (in [coarse])" if coarse else line for line in new]
    refuse(errors)
    return cases[0]


def checked_case(
    table: dict[str, object],
    file: Path,
    *,
    coarse: bool = False,
    sweeps: Collection[str] | None = None,
) -> Case:
    """Check the content of a case file; see `load_case`.

    Parameters
    ----------
    file : its name goes into messages; paths in the case are relative to its folder
    """
    table = deepcopy(table)
    top_keys = set(CaseFile.model_fields)
    over = table.get("coarse")
    apart = {k: v for k, v in over.items() if k in _APART} if isinstance(over, dict) else {}
    if coarse and all(isinstance(value, dict) for value in apart.values()):
        merge(table, apart)
    base = {k: v for k, v in table.items() if k not in top_keys}
    for key in (k for k in base if k not in Mechanism.model_fields):
        if "runs" in table or did_you_mean(key, top_keys):  # else a file of another kind
            known = [*CaseFile.model_fields, *Mechanism.model_fields]
            raise InputError(f"{file}: {printable(key)}: unknown key{meant(key, known)}")
    top = validated(CaseFile, {k: v for k, v in table.items() if k in top_keys}, file)
    findings = Findings(file, {name: run.variants for name, run in top.runs.items()})
    quick = {k: v for k, v in top.coarse.items() if k not in _APART} if coarse else {}

    def merged_with(key: str, variants: list[str]) -> dict[str, object]:
        merged = deepcopy(base)
        for variant in variants:
            findings.add(unknown(f"{file}: {key}.variants", variant, "variant", top.variants))
            merge(merged, top.variants.get(variant, {}))
        merge(merged, quick)
        return merged

    specs = BodySpecs(file.parent, top.units)
    runs: dict[str, Mechanism] = {}
    sound = set[str]()  # runs that sweeps and studies may vary
    bodies: dict[str, dict[str, BodySpec]] = {}
    findings.add(
        f"{file}: {table}.{name}: expected another name, build/CASE has {RESERVED[table][name]}"
        for table, names in (("runs", top.runs), ("sweeps", top.sweeps))
        for name in RESERVED[table].keys() & names.keys()
    )

    def made(
        key: str, variants: list[str]
    ) -> tuple[Mechanism | None, dict[str, BodySpec], list[str]]:
        """Return a mechanism with variants, its bodies, and what is wrong with it."""
        merged = merged_with(key, variants)
        try:
            mechanism, texts = mechanism_of(merged, file.parent, top.units)
        except ValidationError as error:
            return None, {}, [_renamed(line, base) for line in bare_lines(error, Mechanism)]
        mechanism, own, errors = in_parts(mechanism, specs)
        errors += [] if top.units == "m" else _in_two_units(mechanism, texts, top.units)
        return mechanism, own, errors

    for name, run in top.runs.items():
        made_of, own, errors = made(f"runs.{name}", run.variants)
        findings.of_run(name, errors)
        if made_of is None:
            continue
        runs[name], bodies[name] = made_of, own
        if not errors:
            sound.add(name)
    if not findings:  # otherwise a run that is wrong would be missing
        for name, mechanism in runs.items():
            findings.of_run(name, check_elsewhere(mechanism, runs))
        used = {v for run in top.runs.values() for v in run.variants}
        used |= {v for sweep in top.sweeps.values() for v in sweep.variants}
        for variant in (v for v in top.variants if v not in used):
            wrong = (made(f"runs.{n}", [*run.variants, variant])[2] for n, run in top.runs.items())
            lines = next(wrong)  # fits one run at least
            if lines and all(wrong):
                findings.add(f"{file}: {line} (variant {variant}, of no run)" for line in lines)
    findings.add(f"{file}: {line}" for line in _figures(top, runs))

    def merged_of(key: str = "", variants: Sequence[str] = ()) -> MergedOf:
        """Return the tables of runs with variants that `key` adds."""
        return lambda run: merged_with(key or f"runs.{run}", [*top.runs[run].variants, *variants])

    def varied(key: str, sweep: Sweep) -> CheckedSweep:
        of_sweep = merged_of(key, sweep.variants)
        return check_sweep(f"{file}: {key}", sweep, specs, of_sweep)

    checked_sweeps: dict[str, CheckedSweep] = {}
    for name, sweep in top.sweeps.items():
        key = f"sweeps.{name}"
        findings.add(unknown(f"{file}: {key}.run", sweep.run, "run", top.runs))
        if sweep.run in sound and (sweeps is None or name in sweeps):
            with findings.of_sweep(key):
                checked_sweeps[name] = varied(key, sweep)
    studies: dict[str, CheckedStudy] = {}
    for name, study in (top.design.studies if top.design else {}).items():
        key = f"design.studies.{name}"
        findings.add(unknown(f"{file}: {key}.run", study.run, "run", top.runs))
        if study.run in sound and top.design is not None:
            with findings.of_sweep(key):
                studies[name] = check_study(f"{file}: {key}", name, top.design, specs, merged_of())
    if findings:
        raise InputError("\n".join(findings.lines()))
    return Case(case_name(file), file, top, runs, bodies, varied, checked_sweeps, studies)


def _renamed(line: str, base: Tables) -> str:
    """Return a message; of a table that a variant begins, with the one that it may have meant."""
    found = re.match(r"(\w+)\.([\w-]+)\.(\w+): missing", line)
    group, name, key = found.groups() if found else ("", "", "")
    there = base.get(group)
    hint = did_you_mean(name, there) if isinstance(there, dict) and name not in there else ""
    return f"{group}.{name}: not in the case{hint} A new one needs {key}" if hint else line


def _in_two_units(mechanism: Mechanism, texts: Mapping[str, str], unit: str) -> Iterator[str]:
    """Yield parameters that lengths in the unit of the file and forces in SI read alike."""
    forces = repr(mechanism.model_dump(include={"forces"}))
    for key, text in texts.items():
        if unit_at(mechanism, key, Path()) != "m":
            continue
        for name in mechanism.parameters:
            if re.search(rf"\b{name}\b", text) and re.search(rf"\b{name}\b", forces):
                yield (
                    f'{key} = "{text}": a length in {unit} by the parameter {name}, which a force '
                    'reads in SI; expected another parameter, or units = "m"'
                )


def _figures(top: CaseFile, runs: Mapping[str, Mechanism]) -> Iterator[str]:
    """Yield what figures name and the case does not have."""
    for name, figure in top.figures.items():
        for run in figure.runs:
            yield from unknown(f"figures.{name}.runs", run, "run", top.runs)
        for mechanism in runs.values():
            for key, signal in (("signal", figure.signal), ("against", figure.against)):
                if signal is not None:
                    yield from unknown(f"figures.{name}.{key}", signal, "signal", mechanism.signals)


def source_files(case: Case) -> list[Path]:
    """Return the files that runs and sweeps of a case read: descriptions, meshes, tables, code."""
    swept = [each for sweep in case.sweeps.values() for each in (sweep.own, *sweep.others.values())]
    mechanisms = [*case.runs.values(), *(members.base for members in swept)]
    bodies = [*case.bodies.values(), *(body for members in swept for body in members.bodies)]
    sources = {file for specs in bodies for spec in specs.values() for file in spec.sources}
    folder = case.file.parent
    sources |= {file for mechanism in mechanisms for file in _law_sources(mechanism, folder)}
    return sorted(sources)


def _law_sources(mechanism: Mechanism, folder: Path) -> list[Path]:
    """Return the files beside the case file that its laws of time come from."""
    laws: list[Any] = []
    for joint in mechanism.joints.values():
        laws += drives(joint).values()
    laws += [law(force) for force in mechanism.forces.values()]
    tables: list[Any] = [each.table for each in laws if each is not None]
    tables += mechanism.tables.values()
    codes = [code for force in mechanism.forces.values() if (code := getattr(force, "code", None))]
    files = [t.file for t in (*tables, *codes) if t is not None]
    for code in codes:
        files += [*code.reads, *(Path(code.file).with_name(f"{name}.py") for name in code.modules)]
    files += [getattr(body, "picture", None) for body in mechanism.bodies.values()]
    if (rotor := mechanism.rotor) is not None:
        files += [rotor.wind.file, rotor.table, rotor.polar_table]
        files += [rotor.wind.speed and rotor.wind.speed.table and rotor.wind.speed.table.file]
    return [folder / file for file in files if file is not None]
