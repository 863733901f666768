"""The 6x6 stiffness of a section by its warping, its error, and stress recovery."""
