"""What is judged after a run."""
