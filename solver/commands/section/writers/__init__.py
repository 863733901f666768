"""Input files of other codes from section files."""
