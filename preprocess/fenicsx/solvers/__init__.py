"""Factorisations and eigenpairs by PETSc and SLEPc."""
