"""A mechanism as an FMU: FMI 2.0 and 3.0 for co-simulation."""

VERSIONS = {"fmu": "2.0", "fmu3": "3.0"}  # of FMI, by the target of an export
