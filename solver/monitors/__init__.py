"""What is watched during a run: spin, singular positions, energy."""
