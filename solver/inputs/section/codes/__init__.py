"""Cross-sections in the input files of other codes."""
