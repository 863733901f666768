"""The command `plymotion plan`."""
