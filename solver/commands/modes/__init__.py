"""The command `plymotion modes`."""
