"""Solids in TOML: description, checks, specification for the FE side."""
