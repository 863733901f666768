"""Unknowns of the warping of a section, plies and strains at its points."""
