"""Commands on cases, runs and sweeps."""
