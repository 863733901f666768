"""No command replaces a file that it has not written, or writes through a planted link."""

import os
import random
import shutil
from pathlib import Path

import pytest
from harness.hostile_profile import count, tries
from samples import fidelity_packages
from samples.blade_samples import write_blade
from samples.case_samples import HEAD, SOLVER, rigid
from samples.sweep_samples import FORCE, ball

import plymotion as pm
from plymotion.preprocess.exchange.__main__ import main as exchange
from plymotion.solver.__main__ import main as command
from plymotion.solver.commands.body_arguments import written_formats

CASE = HEAD + rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)}) + SOLVER.format(t_end=1, step=0.5, more="")
FOREIGN = "a file of others where a command writes"
LINKS = "a planted link where a command writes"
WORDS = "the only copy of a thesis\n"


def main(words):
    """Run a command in this process; `export`, which is one of the preprocessor, as well."""
    words = [str(word) for word in words]
    mine = words[0] == "export" and not any(word.startswith("fmu") for word in words)
    return (exchange if mine else command)(words)


@pytest.mark.parametrize("stem", [".", ".."])
def test_a_file_of_dots_writes_nowhere_else(repository, tmp_path, monkeypatch, capsys, stem):
    """The stem of "...toml" is "..", and so is the folder of its files."""
    text = (repository / "cases/sections/square.toml").read_text()
    (tmp_path / f"{stem}.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "deep/out"
    assert main(["section", str(tmp_path / f"{stem}.toml"), "--check", "--out", str(out)]) == 2
    assert "expected a file with a name before its ending" in capsys.readouterr().err
    for words in (["run"], ["blade", "--check"]):
        assert main([*words, str(tmp_path / f"{stem}.toml")]) == 2
        assert "expected a file with a name before its ending" in capsys.readouterr().err
    assert [file.name for file in tmp_path.rglob("*") if file.is_file()] == [f"{stem}.toml"]


@pytest.fixture
def case(tmp_path, monkeypatch):
    """A case that is checked, in a folder that is the current one."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "case.toml").write_text(CASE)
    return Path("mine/case.toml")


@pytest.fixture
def package(repository, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = repository / "tests/packages/double-pendulum-limits/arm.isotropic-paper.vtkhdf"
    return Path(shutil.copy(source, tmp_path / "arm.vtkhdf"))


def refused(words, files, capsys):
    """The command is refused, names one of the files, and leaves all as they are."""
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(WORDS)
        assert main(words) == 2, file
        told = capsys.readouterr()
        shown = told.err + told.out
        assert f"{file}: already exists and was not written by Plymotion" in shown or (
            f"{Path(*file.parts[-2:])} already exists" in shown
            or f"{file.name} already exists" in shown
        )
        assert file.read_text() == WORDS
        file.unlink()
        count(FOREIGN, "refused")


FILES = ["base/result.vtkhdf", "base/summary.json", "report.html", "case.json", "runs/base.json"]
FILES += ["finished.json"]


@pytest.mark.parametrize("name", FILES)
def test_run(case, capsys, name):
    refused(["run", case, "--out", "out", "--quiet"], [Path("out") / name], capsys)
    refused(["run", case, "--quiet"], [Path("build/mine") / name], capsys)


def test_what_a_run_has_written_is_replaced(case, capsys):
    """By the same command, by another, and after a copy of the folder."""
    for out in ("out", "copy"):
        for _ in range(2):
            assert main(["run", case, "--out", out, "--force", "--figures", "--quiet"]) == 0
            run = ["run", f"{out}/runs/base.json", "--quiet"]
            assert main(run) == 0
            assert main(["report", out, "--glb", "--vtk"]) == 0
        if out == "out":
            shutil.copytree("out", "copy")
    assert capsys.readouterr().err == ""


def test_sweep_and_modes(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    file = ball(tmp_path, f"{FORCE} = [0.0, 1.0]", 'histories = ["x"]')
    words = ["sweep", str(file), "--quiet", "--no-figures", "--out", "s"]
    refused(words, [Path("s/sweep.h5"), Path("s/sweep.csv")], capsys)
    modes = ["modes", str(tmp_path / "case.toml"), "--out", "m", "--quiet", "--shapes", "0"]
    refused(modes, [Path("m/modes.json")], capsys)


def test_section_and_blade(repository, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    description = repository / "cases/sections/square.toml"
    names = ["square/square.json", "square/square.vtkhdf"]
    words = ["section", description, "--out", "out", "--check"]
    refused(words, [Path("out") / name for name in names], capsys)
    (tmp_path / "list.txt").write_text(f"{description}\n")
    words = ["section", "--batch", "list.txt", "--out", "out"]
    refused(words, [Path("out/summary.csv"), Path("out/summary.json")], capsys)
    file = write_blade(tmp_path)
    names = ["blade.csv", "beam.csv", "case.toml", "stations/r05000.msh", "stations/r05000.toml"]
    words = ["blade", file, "--at", "0.5", "--check", "--out", "out"]
    refused(words, [Path("out") / name for name in names], capsys)


@pytest.mark.parametrize("code", [code for code in written_formats() if not code.startswith("fmu")])
def test_export(package, capfd, code):
    out = Path("thesis.txt")
    words = ["export", package, "--to", code, "--out", out]
    if code == "dmig":  # this body has no static shapes, which is told first
        out.write_text(WORDS)
        assert main(words) == 2
        assert out.read_text() == WORDS
        return
    refused(words, [out], capfd)
    for _ in range(2):
        assert main(words) == 0


def linked(words, file, capsys):
    """A link in place of a file, or of a folder below the named one, is not followed."""
    Path("thesis").write_text(WORDS)
    Path(file).symlink_to(Path("thesis").absolute())
    assert main(words) == 2
    assert f"{file}: already exists" in capsys.readouterr().err
    assert Path("thesis").read_text() == WORDS
    assert Path(file).is_symlink()
    Path(file).unlink()
    count(LINKS, "refused")


@pytest.mark.skipif(shutil.which(os.environ.get("CC") or "cc") is None, reason="no C compiler")
@pytest.mark.parametrize(
    ("code", "written"), [("fmu", "build/mine/base.fmu"), ("fmu3", "mine.fmu")]
)
def test_an_fmu(case, capsys, code, written):
    """What it has written itself is replaced; one file for each version, as each is compiled."""
    for more in ([], ["-o", "mine.fmu"]):
        words = ["export", case, "--to", code, *more]
        file = Path(more[-1] if more else "build/mine/base.fmu")
        refused(words, [file], capsys)
        linked(words, file, capsys)
        for _ in range(2 if str(file) == written else 0):
            assert main(words) == 0
    Path("build/mine").rename("elsewhere")
    Path("build/mine").symlink_to("../elsewhere", target_is_directory=True)
    assert main(["export", case, "--to", code]) == 2
    assert "build/mine is a link to" in capsys.readouterr().err


def test_a_chart(tmp_path, monkeypatch, capsys):
    """Refused before the work, which takes long."""
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(fidelity_packages.CASE)
    assert main(["check", "case.toml", "--out", "out"]) == 0
    Path("ready").mkdir()
    fidelity_packages.build_bodies(Path("out/bodies"), Path("ready"))
    words = [
        "plan",
        "--chart",
        "case.toml",
        "--out",
        "out",
        "--packages",
        "ready",
        "--figure",
        "chart.png",
    ]
    files = [Path(name) for name in ("chart.png", "out/plans/base.ladder.json")]
    refused(words, files, capsys)
    linked(words, files[0], capsys)
    assert not Path("out/plans").exists() or not any(Path("out/plans").iterdir())
    refused(words[:-2], [Path("out/plans/base.png")], capsys)
    assert main(words) == 0


def test_merged_shards(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    file = ball(tmp_path, f"{FORCE} = [0.0, 1.0]", 'histories = ["x"]')
    for shard in ("1/2", "2/2"):
        words = ["sweep", file, "--shard", shard, "--quiet", "--no-figures", "--out", "s"]
        refused(words, [Path(f"s/sweep-{shard[0]}-of-2.h5")], capsys)
        assert main(words) == 0
    words = ["sweep", "--merge", file, "--no-figures", "--out", "s"]
    for name in ("sweep.h5", "sweep.csv"):
        refused(words, [Path("s") / name], capsys)
        linked(words, Path("s") / name, capsys)
    for _ in range(2):
        assert main(words) == 0


@pytest.mark.parametrize("planted", ["out/base", "build/mine", "build/mine/base", "out/runs"])
def test_no_planted_link_is_followed(case, tmp_path, capsys, planted):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    Path(planted).parent.mkdir(parents=True)
    Path(planted).symlink_to(elsewhere, target_is_directory=True)
    more = ["--out", "out"] if planted.startswith("out") else []
    assert main(["run", str(case), *more, "--quiet"]) == 2
    assert f"{planted} is a link to {elsewhere}" in capsys.readouterr().err
    assert not any(elsewhere.iterdir())
    count(LINKS, "refused")


IN_PYTHON = {
    "run": lambda case, more: pm.run(case, **more),
    "sweep": lambda case, more: pm.sweep(case, vary={"bodies.ball.mass": [1.0, 2.0]}, **more),
    "plan": lambda case, more: pm.plan(case, **more),
}


@pytest.mark.parametrize("name", IN_PYTHON)
def test_the_same_rule_in_python(case, tmp_path, name):
    """A link in build/ is refused, a link that the user has named is followed."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    Path("build").mkdir()
    for link in ("build/mine", "named"):
        Path(link).symlink_to(elsewhere, target_is_directory=True)
    loaded = pm.load(case)
    loaded.signals["x"] = {"kind": "position", "at": "ball.c", "component": "x"}
    if name == "plan":
        loaded.fidelity = {"accuracy": 1e-3, "signals": ["x"]}
    with pytest.raises(pm.InputError, match=f"build/mine is a link to {elsewhere}"):
        IN_PYTHON[name](loaded, {})
    assert not any(elsewhere.iterdir())
    IN_PYTHON[name](loaded, {"out": "named"})
    assert any(elsewhere.iterdir())
    count(LINKS, "refused")


def test_a_section_in_python(repository, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("build").mkdir()
    Path("build/sections").symlink_to(tmp_path, target_is_directory=True)
    with pytest.raises(pm.InputError, match="build/sections is a link to"):
        pm.Section.from_file(repository / "cases/sections/square.toml")
    assert not (tmp_path / "square").exists()


def test_no_planted_link_of_a_run_file_is_followed(case, tmp_path, capsys):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    assert main(["check", str(case), "--out", "out"]) == 0
    Path("out/base").symlink_to(elsewhere, target_is_directory=True)
    for words in ([], ["--jobs", "2"]):
        assert main(["run", "out/runs/base.json", "--quiet", *words]) == 2
        assert f"is a link to {elsewhere}" in capsys.readouterr().err
    assert not any(elsewhere.iterdir())


def test_folders_on_other_disks_are_the_users_choice(case, tmp_path):
    """A link `build`, one that --out names, one within the folder."""
    for name in ("disk", "other"):
        (tmp_path / name).mkdir()
    Path("build").symlink_to(tmp_path / "disk", target_is_directory=True)
    Path("named").symlink_to(tmp_path / "other", target_is_directory=True)
    assert main(["run", str(case), "--quiet"]) == 0
    assert (tmp_path / "disk/mine/report.html").is_file()
    assert main(["run", str(case), "--out", "named", "--quiet"]) == 0
    assert (tmp_path / "other/report.html").is_file()
    os.rename("named/base", "named/kept")
    Path("named/base").symlink_to("kept", target_is_directory=True)
    assert main(["run", str(case), "--out", "named", "--force", "--quiet"]) == 0


def test_a_link_in_place_of_a_file_is_not_followed(case, tmp_path):
    (tmp_path / "thesis").write_text(WORDS)
    Path("out").mkdir()
    Path("out/report.html").symlink_to(tmp_path / "thesis")
    assert main(["run", str(case), "--out", "out", "--quiet"]) == 2
    assert (tmp_path / "thesis").read_text() == WORDS
    assert Path("out/report.html").is_symlink()


# Commands whose outputs are quick to make, with "OUT" for the folder or file that they write.
COMMANDS = {
    "check": "check mine/case.toml --out OUT",
    "run": "run mine/case.toml --out OUT --quiet",
    "report": "report OUT --glb --vtk",
    "modes": "modes mine/case.toml --out OUT --shapes 0 --quiet",
    "section": "section square.toml --check --out OUT",
    "blade": "blade small.yaml --at 0.5 --check --out OUT",
    "export": "export arm.vtkhdf --to uff -o OUT/arm.uff",
    "mujoco": "export arm.vtkhdf --to mujoco -o OUT/arm.xml",
    "exudyn": "export arm.vtkhdf --to exudyn -o OUT/arm.py",
    "med": "export arm.vtkhdf --to med -o OUT/arm.med",
    "new": "new robot-arm OUT",
}


@pytest.mark.parametrize("name", COMMANDS)
def test_every_output_in_turn(case, package, repository, tmp_path, capfd, name):
    """Another file, or a link to one, or a link in place of the folder around it."""
    shutil.copy(repository / "cases/sections/square.toml", tmp_path)
    write_blade(tmp_path)

    def ended(out):
        before = "run mine/case.toml --out OUT --quiet" if name == "report" else ""
        for line in filter(None, [before, COMMANDS[name]]):
            code = main(line.replace("OUT", out).split())
            if code:
                return code
        return 0

    assert ended("first") == 0
    first = Path("first")
    written = sorted(p.relative_to(first) for p in first.rglob("*") if p.is_file())
    written = [file for file in written if file.name != "plymotion-files.txt"]
    thesis, elsewhere = tmp_path / "thesis", tmp_path / "elsewhere"
    thesis.write_text(WORDS)
    elsewhere.mkdir()
    ways = [(file, way) for file in written for way in ("file", "link", "folder")]
    chosen = random.Random(7).sample(ways, min(len(ways), tries(4, 30)))
    for k, (file, way) in enumerate(chosen):
        out = Path(f"out{k}")
        place = out / file
        if way == "folder":
            if place.parent == out:  # the folder that the user has named
                continue
            place.parent.parent.mkdir(parents=True)
            place.parent.symlink_to(elsewhere, target_is_directory=True)
        else:
            place.parent.mkdir(parents=True)
            if way == "link":
                place.symlink_to(thesis)
            else:
                place.write_text(WORDS)
        code = ended(str(out))
        told = capfd.readouterr()
        kept = thesis.read_text() == WORDS and not any(elsewhere.iterdir())
        kept = kept and (way == "folder" or place.read_text() == WORDS)
        count(LINKS if way != "file" else FOREIGN, "refused" if kept else "file lost")
        assert code == 2, (file, way, told)
        assert kept, (file, way, told)
