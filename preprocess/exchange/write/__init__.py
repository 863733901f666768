"""Writers: one file per format, each with `write(package, out, source)`."""
