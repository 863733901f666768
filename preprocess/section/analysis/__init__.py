"""The analysis of a section from its description to its file."""
