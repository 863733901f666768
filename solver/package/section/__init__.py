"""The file of a beam cross-section (docs/section-file.md)."""
