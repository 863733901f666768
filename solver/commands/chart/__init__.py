"""The command `plymotion chart`."""
