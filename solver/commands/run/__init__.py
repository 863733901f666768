"""The command `plymotion run`."""
