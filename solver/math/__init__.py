"""Arrays, rotations, laws of time and compilation: what everything else stands on."""
