"""Size, time until ready and accessibility of the reports of cases, in Chromium without a GPU.

python benchmarks/report_pages.py [CASE ...]    build/CASE/report.html; default: all that are there

Prints the table of docs/report.md, with four more columns. `ready` is the time from opening the
page to its mark that everything is drawn, the least of five; `CPU` is what all processes of the
browser took for it, so that other work on the machine does not count, and `page` the share of the
page's own thread.
Needs build/browser/axe.min.js (tools/browser.sh) and runs with PYTHONPATH=.:tests.
"""

import sys
import tempfile
from pathlib import Path

from harness.chromium import SOFTWARE, Browser

BUILD = Path("build")
AXE = BUILD / "browser/axe.min.js"
TIMES = 5
HEAD = ["case", "size [MB]", "drawn by", "ready [s]", "CPU [s]", "page [s]"]
HEAD += ["errors", "requests", "axe, serious"]
SERIOUS = """axe.run(document).then(({ violations }) =>
  violations.filter((v) => ['serious', 'critical'].includes(v.impact)).map((v) => v.id))"""


def measure(page: Path) -> list[str]:
    """Return the columns of a page's row."""
    ready, cpu, own, serious, errors = [], [], [], [], []
    requests, renderer = 0, ""
    for k in range(TIMES):
        dark = k == TIMES - 1
        with (
            tempfile.TemporaryDirectory() as folder,
            Browser(Path(folder) / "profile", *SOFTWARE, dark=dark) as browser,
        ):
            browser.call("Performance.enable", timeDomain="threadTicks")
            before = browser.cpu_seconds()
            ready.append(browser.open(page))
            cpu.append(browser.cpu_seconds() - before)
            metrics = browser.call("Performance.getMetrics")["metrics"]
            own += [each["value"] for each in metrics if each["name"] == "TaskDuration"]
            renderer = browser.run("document.documentElement.dataset.renderer || 'none'")
            requests = max(requests, len(browser.requests()))
            errors += browser.errors()
            if k == 0 or dark:
                browser.run(AXE.read_text(encoding="utf-8") + "; 0")
                serious += browser.run(SERIOUS)
    size = page.stat().st_size / 1e6
    return [
        f"{size:.2f}",
        renderer,
        f"{min(ready):.2f}",
        f"{min(cpu):.2f}",
        f"{min(own):.2f}",
        str(len(errors)),
        str(requests),
        ", ".join(sorted(set(serious))) or "none",
    ]


def main(names: list[str]) -> None:
    """Measure the pages one after the other."""
    pages = [BUILD / name / "report.html" for name in names]
    print(f"| {' | '.join(HEAD)} |")
    print("|---" * len(HEAD) + "|")
    found = sorted(file.parent / "report.html" for file in BUILD.glob("*/case.json"))
    for page in pages or [page for page in found if page.is_file()]:
        print(f"| {page.parent.name} | {' | '.join(measure(page))} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
