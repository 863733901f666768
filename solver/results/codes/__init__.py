"""The one list of codes of findings; docs/warnings.md is generated from it (`make docs`)."""

from . import course, members, motion, packages

RUN_CODES = (*course.CODES, *motion.CODES)
GROUPS = {
    "Runs": RUN_CODES,
    "Members of a sweep without a result": members.CODES,
    "Bodies": packages.BODY_CODES,
    "Shells and laminates": packages.SHELL_CODES,
    "Cross-sections": packages.SECTION_CODES,
    "Blades": packages.BLADE_CODES,
}
CODES = {code.name: code for group in GROUPS.values() for code in group}
