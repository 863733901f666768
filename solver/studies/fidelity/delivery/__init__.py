"""From an accuracy to a delivered result, for runs, sweeps and charts."""
