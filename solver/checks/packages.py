"""Warnings that came with the packages of the bodies."""

from collections.abc import Iterator

from ..package.common.plausible import CODES as UNITS
from ..results.codes import CODES
from ..results.finding import Finding
from .finished import FinishedRun


def package_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield the warnings in the provenance of each package.

    A package from elsewhere may have codes of its own.
    """
    for name, package in run.packages.items():
        for item in package.provenance.get("warnings", []):
            if item["code"] in UNITS:  # of a section of the body: materials.py says it
                continue
            code, text = str(item["code"]), f"{name}: {item['message']}"
            known = CODES.get(code)
            yield known.finding(text, body=name) if known else Finding(code, text, name)
