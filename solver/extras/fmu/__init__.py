"""A mechanism as an FMU: FMI 2.0 for co-simulation."""
