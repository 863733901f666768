"""The command `plymotion new`: starter cases."""
