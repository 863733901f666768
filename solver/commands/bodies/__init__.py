"""Commands on sections, shells, solids and packages."""
