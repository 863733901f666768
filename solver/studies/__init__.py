"""A case file from its check to its report: `plymotion case.toml`."""
