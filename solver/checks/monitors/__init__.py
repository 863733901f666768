"""What is watched during a run: spin, buckling, singular positions, energy."""
