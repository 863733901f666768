"""`plymotion blade`: cross-sections of a rotor blade from a windIO file."""
