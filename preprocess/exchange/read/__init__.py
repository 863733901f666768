"""Readers: one file per format, each with `read(files, where) -> FreeBody` or `Measured`."""
