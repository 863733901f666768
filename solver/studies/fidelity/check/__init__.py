"""Runs of a plan and of its check, and what they say of its error."""
