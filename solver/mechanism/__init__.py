"""Build model, names and start of a mechanism from a resolved run and its packages."""
