"""The command `plymotion packages`: modal packages of the bodies of runs and sweeps."""
