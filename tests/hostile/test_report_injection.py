"""Words of a case file are words in report.html, whatever they contain: no script of them runs."""

import pytest
from harness.chromium import Browser
from harness.hostile_profile import count
from samples.sweep_samples import BALL

from plymotion.solver.__main__ import main

# Ends of a script, of a comment, of an attribute; elements that run by themselves.
HOSTILE = (
    "</script></title></style><script>window.struck = 1</script>"
    "<img src=x onerror='window.struck = 2'><svg onload='window.struck = 3'></svg>"
    "<!-- --> ]]> ' ` ${window.struck = 4} {{7*7}} &lt;script&gt; \\u2028 "
)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """A report in which every text of the user is hostile."""
    folder = tmp_path_factory.mktemp("report") / "a<img src=x onerror='window.struck = 5'>'b"
    folder.mkdir()
    text = BALL.replace('title = "', f'title = "{HOSTILE}', 1)
    text = text.replace("[signals.x]", f'[signals.x]\ndescription = "{HOSTILE}"')
    text = text.replace("[runs.base]", f'[runs.base]\ntitle = "{HOSTILE}"\n[runs.two]')
    (folder / "case.toml").write_text(text, encoding="utf-8")
    assert main(["run", str(folder / "case.toml"), "--out", str(folder / "build")]) == 0
    return folder / "build/report.html"


def test_no_script_of_a_text_runs(report, tmp_path):
    with Browser(tmp_path / "profile") as browser:
        browser.open(report)
        # All that can be pressed, opened and selected: texts are shown again elsewhere.
        browser.run("document.querySelectorAll('details').forEach(d => { d.open = true })")
        browser.run("document.querySelectorAll('button, summary').forEach(b => b.click())")
        browser.run(
            "document.querySelectorAll('select, input').forEach("
            "i => i.dispatchEvent(new Event('change', {bubbles: true})))"
        )
        browser.run(
            "document.querySelectorAll('svg, canvas').forEach("
            "i => i.dispatchEvent(new MouseEvent('mousemove', {bubbles: true})))"
        )
        browser.run("new Promise(done => setTimeout(done, 300))")
        assert browser.run("String(window.struck)") == "undefined"
        made = "document.querySelectorAll('[onerror], [onload], img[src=x]').length"
        assert browser.run(made) == 0
        assert "window.struck = 1" in browser.run("document.body.innerText")
    count("report: hostile words in titles, descriptions, paths", "done")
