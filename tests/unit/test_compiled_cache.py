"""The cache of compiled functions: keyed by content, shared, and never trusted blindly."""

import importlib.metadata
import json
import os
import pickle
import shutil
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from harness.forks import Forks
from harness.processes import this_python
from samples.constraint_runs import prepared
from samples.mechanism_samples import chain

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment

# Not `importorskip`: Numba takes long to load, and each worker of pytest reads this file.
pytestmark = pytest.mark.skipif(find_spec("numba") is None, reason="Numba is not installed")

MODULE = """
import numpy as np
from plymotion.solver.math.compiled import inlined, lean

FACTOR = {factor}


@inlined
def part(x):
    return FACTOR * x


@lean
def unit(x):
    return part(x) + {shift}


@lean
def entry(a):
    total = {start}
    for i in range(a.shape[0]):
        total += unit(a[i])
    return total
"""
SCRIPT = """
import os, sys
if sys.argv[1:]:
    sys.path.insert(0, sys.argv[1])
    # Python takes bytecode of another text of the same second and size for this one's.
    sys.dont_write_bytecode = True
exec(os.environ.get("SETUP", ""))
import numpy as np
from plymotion.solver.math.compiled import COMPILED, statistics
import sample
value = complex(sample.entry(np.arange(4.0))).real
names = sorted(name.partition(":")[2] for name in statistics.compiled)
print(value, COMPILED, len(statistics.loaded), len(statistics.fallbacks), *names)
"""


def _call(folder: Path, cache: Path | None, **changes):
    """Write the module in a folder and call it; return the value and what was compiled."""
    return _read(_started(folder, cache, **changes))


def _started(folder, cache, factor=2.0, shift=1.0, start=0.0, **settings):
    """Start a process, by default without a linker."""
    folder.mkdir(exist_ok=True)
    (folder / "sample.py").write_text(MODULE.format(factor=factor, shift=shift, start=start))
    common = {"PLYMOTION_COMPILED": "1", "PLYMOTION_CACHE": str(cache or ""), "PATH": ""}
    settings = common | settings
    return _forks.started(SCRIPT, str(folder), **settings)


# Numba with most of what it loads when it compiles for the first time, and nothing of ours.
LOADED = """core.typing.arraydecl core.typing.cmathdecl cpython.cmathimpl cpython.printimpl
    cpython.setobj cpython.tupleobj experimental.function_type misc.cffiimpl np.arraymath
    np.npyimpl np.random.generator_methods typed.typeddict typed.typedlist"""
_forks = Forks([f"numba.{name}" for name in LOADED.split()])


@pytest.fixture(scope="module", autouse=True)
def forks():
    yield
    _forks.end()


def _read(process):
    out, err = process.communicate(300.0)
    assert process.returncode == 0, err
    return _found(out)


def _found(out):
    value, compiled, loaded, fallbacks, *names = out.split()
    return float(value), compiled == "True", int(loaded), int(fallbacks), names


@pytest.fixture(scope="module")
def compiled_once(tmp_path_factory):
    """A cache into which the module was compiled."""
    folder = tmp_path_factory.mktemp("compiled")
    found = _call(folder / "one", folder / "cache")
    assert found == (16.0, True, 0, 0, ["entry", "unit"])
    return folder / "cache"


@pytest.fixture
def filled(compiled_once, tmp_path):
    """A copy of that cache for one test."""
    return Path(shutil.copytree(compiled_once, tmp_path / "cache"))


def test_same_content_in_another_folder_is_found(tmp_path, filled):
    assert _call(tmp_path / "two", filled) == (16.0, True, 2, 0, [])


def test_an_edit_compiles_what_it_changes(tmp_path, filled):
    cache = filled
    # a unit of its own: its callers only know its name
    assert _call(tmp_path / "one", cache, shift=3.0) == (24.0, True, 1, 0, ["unit"])
    # a global constant, of an inlined part
    assert _call(tmp_path / "one", cache, factor=3.0) == (22.0, True, 1, 0, ["unit"])
    # both are still there
    assert _call(tmp_path / "one", cache) == (16.0, True, 2, 0, [])


def test_a_result_of_another_type_compiles_the_callers(tmp_path, filled):
    assert _call(tmp_path / "one", filled, shift="(1.0 + 1.0j)")[0::4] == (16.0, ["entry", "unit"])


PATH = os.environ["PATH"]
LINKER = shutil.which("cc")
# Code that is loaded in another way than from the library would be compiled by numba.njit.
NO_LLVM = "import plymotion.solver.math.compiled.machine as module; module.add = None"
needs_linker = pytest.mark.skipif(LINKER is None, reason="no linker")


def test_two_processes_at_once(tmp_path):
    cache = tmp_path / "cache"
    running = [_started(tmp_path / "one", cache, PATH=PATH) for _ in range(2)]
    assert {_read(process)[0] for process in running} == {16.0}
    assert _call(tmp_path / "one", cache, SETUP=NO_LLVM if LINKER else "")[4] == []
    assert not list(cache.rglob(".new-*"))


def _cut(path):
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])


def _flipped(path):
    data = bytearray(path.read_bytes())
    data[-20] ^= 0xFF
    path.write_bytes(data)


def _empty(path):
    path.write_bytes(b"")


def _files(cache):
    """Files of the unit, of its caller, and of the caller's entry from Python."""
    files = {json.loads(f.read_bytes().split(b"\n")[1])["name"]: f for f in cache.rglob("code/*")}
    return [files.pop(f"sample:{name}") for name in ("unit", "entry", "entry from Python")]


DAMAGES = [_cut, _flipped, _empty]


@pytest.mark.parametrize("first", range(3))
def test_a_damaged_file_is_compiled_anew(tmp_path, filled, first):
    """Each damage to each file. Files that are gone: the next test."""
    cache = filled
    for k, path in enumerate(_files(cache)):
        DAMAGES[(first + k) % 3](path)
    assert _call(tmp_path / "one", cache) == (16.0, True, 0, 0, ["entry", "unit"])
    if first == 0:  # the files are whole again, whatever they were
        assert _call(tmp_path / "one", cache)[4] == []


def test_one_lost_unit_is_compiled_before_its_caller_is_loaded(tmp_path, filled):
    cache = filled
    unit, entry, _ = _files(cache)
    unit.unlink()
    assert _call(tmp_path / "one", cache) == (16.0, True, 1, 0, ["unit"])
    entry.unlink()
    assert _call(tmp_path / "one", cache) == (16.0, True, 1, 0, ["entry"])


@pytest.fixture(scope="module")
def linked_once(compiled_once, tmp_path_factory):
    """A cache with a library."""
    folder = tmp_path_factory.mktemp("linked")
    shutil.copytree(compiled_once, folder / "cache")
    assert _call(folder / "one", folder / "cache", PATH=PATH) == (16.0, True, 2, 0, [])
    return folder / "cache"


@pytest.fixture
def linked(linked_once, tmp_path):
    """A copy of that cache for one test."""
    return Path(shutil.copytree(linked_once, tmp_path / "cache"))


def _library(cache):
    """Return the file of the library, and its units by symbol."""
    for file in cache.glob("code/*"):
        head = json.loads(file.read_bytes().split(b"\n")[1])
        if head["name"] == "library":
            return file, head["units"]
    raise FileNotFoundError


@needs_linker
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_library_is_linked_anew(tmp_path, linked, damage):
    """What it had comes from files in the meantime."""
    assert _call(tmp_path / "one", linked, SETUP=NO_LLVM) == (16.0, True, 2, 0, [])
    damage(_library(linked)[0])
    assert _call(tmp_path / "one", linked, PATH=PATH) == (16.0, True, 2, 0, [])
    assert _call(tmp_path / "one", linked, SETUP=NO_LLVM) == (16.0, True, 2, 0, [])


@needs_linker
def test_edits_leave_nothing_of_the_library_out_of_date(tmp_path, linked):
    # of a unit: its caller in the library calls what it was
    assert _call(tmp_path / "one", linked, shift=3.0, PATH=PATH) == (24.0, True, 1, 0, ["unit"])
    assert _call(tmp_path / "one", linked, shift=3.0, SETUP=NO_LLVM) == (24.0, True, 2, 0, [])
    # of the caller: it is compiled, and calls what the library has
    found = _call(tmp_path / "one", linked, shift=3.0, start=1.0, PATH=PATH)
    assert found == (25.0, True, 1, 0, ["entry"])
    # of the type of a result
    found = _call(tmp_path / "one", linked, shift="(1.0 + 1.0j)", PATH=PATH)
    assert found == (16.0, True, 0, 0, ["entry", "unit"])
    assert _call(tmp_path / "one", linked, shift="(1.0 + 1.0j)", SETUP=NO_LLVM)[2:4] == (2, 0)


@needs_linker
def test_a_caller_in_the_library_of_another_result_is_compiled(tmp_path, linked):
    """The unit was edited and linked again by a process that did not need its caller."""
    alone = "import sample; sample.unit(1.0); sample.entry = abs"
    alone += "; import numpy; numpy.arange = float"
    changes = {"shift": "(1.0 + 1.0j)", "PATH": PATH}
    assert _call(tmp_path / "one", linked, SETUP=alone, **changes)[4] == ["unit"]
    assert _call(tmp_path / "one", linked, **changes) == (16.0, True, 1, 0, ["entry"])
    changes["PATH"] = ""
    assert _call(tmp_path / "one", linked, SETUP=NO_LLVM, **changes)[2:] == (2, 0, [])


@needs_linker
def test_what_another_process_has_linked_meanwhile_is_kept(tmp_path, linked):
    """The way from Python to a unit, which this process calls by way of another one."""

    def door():
        (unit,) = (unit for unit in _library(linked)[1].values() if unit[0] == "sample:unit")
        return unit[3]

    _call(tmp_path / "one", linked, SETUP="import sample; sample.unit(1.0)", PATH=PATH)
    assert door()
    setup = (
        "import plymotion.solver.math.compiled.unit_files as files\n"
        "files._library = lambda: ({}, None)"
    )
    found = _call(tmp_path / "one", linked, start=1.0, SETUP=setup, PATH=PATH)
    assert found == (17.0, True, 1, 0, ["entry"])
    assert door()


@needs_linker
def test_a_library_of_another_processor_is_not_loaded(tmp_path, linked):
    """One that can do less, and one that is called in another way by the user's system."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    if not any(line.startswith("flags") for line in lines):
        pytest.skip("LLVM says what this processor can do")
    other = tmp_path / "cpuinfo"
    setup = "import plymotion.solver.math.compiled.unit_files as kept; "
    setup += f"kept.CPUINFO = {str(other)!r}; "
    cores = [f"{line}1" if line.startswith(("cpu MHz", "siblings")) else line for line in lines]
    other.write_text("\n".join(cores))
    assert _call(tmp_path / "one", linked, SETUP=setup + NO_LLVM) == (16.0, True, 2, 0, [])
    less = [line.rpartition(" ")[0] if line.startswith("flags") else line for line in lines]
    other.write_text("\n".join(less))
    assert _call(tmp_path / "one", linked, SETUP=setup)[2:] == (0, 0, ["entry", "unit"])


@pytest.mark.parametrize("place", ["there", "."])
def test_a_linker_that_fails_is_not_asked_again(tmp_path, filled, monkeypatch, place):
    """One of the current folder is not asked at all."""
    there = tmp_path / "there"
    there.mkdir()
    (there / "cc").write_text(f"#!/bin/sh\necho called >> {tmp_path}/calls\nexit 1\n")
    (there / "cc").chmod(0o755)
    monkeypatch.chdir(there)
    for _ in range(2):
        path = place if place == "." else str(there)
        assert _call(tmp_path / "one", filled, PATH=path) == (16.0, True, 2, 0, [])
    calls = tmp_path / "calls"
    assert (calls.read_text() if calls.exists() else "") == ("" if place == "." else "called\n")


@needs_linker
def test_a_large_library_begins_anew(tmp_path, linked):
    """With what the process has used of it."""
    more = "import sample; sample.unit(1)"
    assert _call(tmp_path / "one", linked, SETUP=more, PATH=PATH)[4] == ["unit"]
    assert len(_library(linked)[1]) == 3
    setup = "import plymotion.solver.math.compiled.linking as linking; linking.MOST_UNITS = 2"
    found = _call(tmp_path / "one", linked, start=1.0, SETUP=setup, PATH=PATH)
    assert found == (17.0, True, 1, 0, ["entry"])
    assert len(_library(linked)[1]) == 2


def test_a_cache_that_cannot_be_written(tmp_path):
    """A file stands where the folder would be: so even for a user who may write anywhere."""
    (tmp_path / "cache").write_text("no folder")
    value, _, loaded, fallbacks, names = _call(tmp_path / "one", tmp_path / "cache")
    assert (value, loaded, fallbacks, names) == (16.0, 0, 0, ["entry", "unit"])
    assert (tmp_path / "cache").read_text() == "no folder"  # so the next one compiles as well


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_cache(tmp_path, filled):
    cache = filled
    for path in (cache / "code", cache):
        path.chmod(0o500)
    try:
        assert _call(tmp_path / "one", cache)[4] == []
        assert _call(tmp_path / "one", cache, shift=3.0)[4] == ["unit"]
    finally:
        for path in (cache, cache / "code"):
            path.chmod(0o700)


def test_a_home_that_is_missing(tmp_path):
    home = tmp_path / "none"
    found = _call(tmp_path / "one", None, HOME=str(home / "deeper"))
    assert found[0] == 16.0
    shutil.rmtree(home, ignore_errors=True)
    home.write_text("a file")
    assert _call(tmp_path / "one", None, HOME=str(home / "deeper"))[4] == ["entry", "unit"]


def test_plain_numpy_and_njit_give_the_same(tmp_path):
    cache = tmp_path / "cache"
    assert _call(tmp_path / "one", cache, PLYMOTION_COMPILED="0")[:2] == (16.0, False)
    assert not cache.exists()
    value, _, _, fallbacks, names = _call(tmp_path / "one", cache, PLYMOTION_COMPILED="njit")
    assert (value, fallbacks, names) == (16.0, 1, [])


def test_no_numba_at_all(tmp_path):
    """In a process of its own, which has never imported it."""
    (tmp_path / "sample.py").write_text(MODULE.format(factor=2.0, shift=1.0, start=0.0))
    path = os.pathsep.join(filter(None, [str(tmp_path), os.environ.get("PYTHONPATH")]))
    changes = {"SETUP": "import sys; sys.modules['numba'] = None", "PYTHONPATH": path}
    changes |= {"PLYMOTION_COMPILED": "1", "PLYMOTION_CACHE": str(tmp_path / "cache")}
    done = this_python("-c", SCRIPT, more=changes)
    assert done.returncode == 0, done.stderr
    assert _found(done.stdout) == (16.0, False, 0, 0, [])


VERSIONS = "import plymotion.solver.math.compiled as units; "
INTERNALS = "import plymotion.solver.math.compiled.{0} as module; module.{1} = None"


@pytest.mark.parametrize(
    ("setup", "words"),
    [
        (VERSIONS + "units.NEWEST = (0, 62)", "knows 0.62 to 0.62"),
        (VERSIONS + "units.LOWEST = (9, 0)", "knows 9.0 to"),
        (INTERNALS.format("machine", "emitted"), "not callable"),
        (INTERNALS.format("lowering", "compile_extra"), "not callable"),
        (INTERNALS.format("lowering", "BUILTINS"), "NoneType"),
    ],
)
def test_another_numba_is_left_to_njit(tmp_path, setup, words):
    if "NEWEST" in setup and _numba_version() <= (0, 62):
        pytest.skip("this Numba is the lowest one that is supported")
    process = _started(tmp_path / "one", tmp_path / "cache", SETUP=setup)
    out, err = process.communicate(300.0)
    assert process.returncode == 0, err
    assert out.split()[:4] == ["16.0", "True", "0", "1"]
    assert words in err
    assert err.count("RuntimeWarning") == 1
    assert "numba.njit compiles it instead" in err


def _numba_version():
    return tuple(int(n) for n in importlib.metadata.version("numba").split(".")[:2])


def test_a_copy_of_a_structure_has_a_table_of_its_own():
    from plymotion.solver.math.compiled.entry_points import table_of

    model, _ = prepared(chain(2), Treatment("index1"))
    table = table_of(model)
    assert table_of(model) is table
    copy = pickle.loads(pickle.dumps(model))
    assert type(copy) is type(model)
    assert table_of(copy).address != table.address
    assert table_of(copy).text == table.text
    other = model._replace(alpha=3.0)
    changed = np.flatnonzero(table_of(other).words != table.words)
    assert changed.size == 1
    assert table_of(other).words[changed].view(float)[0] == 3.0


def test_a_structure_of_what_cannot_be_passed_is_refused():
    from plymotion.solver.math.compiled.entry_points import table_of

    model, _ = prepared(chain(2), Treatment("index1"))
    with pytest.raises(TypeError, match=r"Model\.J0.*contiguous"):
        table_of(model._replace(J0=model.J0[:, ::2]))


def test_calls_as_in_python(tmp_path):
    """Keywords, arguments of other kinds, wrong numbers of them."""
    from plymotion.solver.math.laws import law_value

    pieces = (np.array([0, 1]), np.zeros(1), np.arange(8.0)[None], 0)
    expected = law_value(*pieces, 0.5)
    assert law_value(*pieces, t=0.5) == expected
    assert law_value([0, 1], *pieces[1:], 0.5) == pytest.approx(expected, abs=0)
    with pytest.raises(TypeError):
        law_value(*pieces)
