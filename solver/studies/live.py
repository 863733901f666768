"""A page that follows the runs under way in the folder of a case."""

import json
import os
import time
from collections.abc import Iterator
from pathlib import Path

from ..errors import InputError
from ..package.common.files import write_text
from ..report.report_data import case_table
from ..report.report_page import PAGE, make_report
from ..results.live import FOLDER, answers, ask
from ..system.platform import can_fork, locked

PERIOD_S = 1.0  # between looks for new results
RELOAD_S = 5  # of the page in the browser


def live_page(case_dir: Path) -> Iterator[Path]:
    """Keep live/report.html up to date as long as a command is at work in a folder.

    Yields the page each time that it has new results. At the end it leads to report.html.

    Parameters
    ----------
    case_dir : build/<case>

    Raises
    ------
    InputError
        Nothing is at work there; a system whose processes cannot be copied.
    """
    if not can_fork():
        raise InputError("--live: expected Linux, where a run can be copied while it goes on")
    if not at_work(case_dir):
        raise InputError(
            f"{case_dir}: no command is at work there; expected build/CASE while `plymotion CASE` "
            "integrates its runs"
        )
    begin, place = time.time(), case_dir / FOLDER
    shown: dict[str, float] = {}
    place.mkdir(exist_ok=True)
    try:
        while at_work(case_dir):
            ask(case_dir)
            time.sleep(PERIOD_S)
            now = answers(case_dir, begin)
            if now and now != shown:
                shown = now
                case = case_table(json.loads((case_dir / "case.json").read_text(encoding="utf-8")))
                runs = [run for run in case["runs"] if run in now]
                yield make_report(place, runs, case, reload_s=RELOAD_S)
    finally:
        if shown:
            write_text(place / PAGE, ENDED)


ENDED = (
    f"<!DOCTYPE html><html lang='en'><head><meta http-equiv='refresh' content='0; url=../{PAGE}'>"
    f"<title>ended</title></head><body><a href='../{PAGE}'>{PAGE}</a></body></html>\n"
)


def at_work(case_dir: Path) -> bool:
    """Return whether a command has locked a folder."""
    try:
        descriptor = os.open(case_dir, os.O_RDONLY)
    except OSError:
        return False
    try:
        return not locked(descriptor)
    finally:
        os.close(descriptor)
