"""Robots from URDF files: the file, its links and joints, and the case that they make."""
