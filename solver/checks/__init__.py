"""What is checked after a run, by single runs and sweeps alike: one idea in each file."""
