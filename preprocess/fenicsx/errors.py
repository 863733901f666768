"""What can go wrong with a mesh, a factorisation or an eigenproblem; loads no part of the stack."""


class MeshError(Exception):
    """A gmsh model cannot be used as a finite-element mesh."""


class FactorisationError(Exception):
    """A matrix is not symmetric positive definite."""


class SingularError(FactorisationError):
    """The solution of a random load is so large that the matrix appears to be singular."""


class InertiaError(Exception):
    """The signs of the eigenvalues cannot be counted: the matrix is singular to round-off."""


class EigenError(Exception):
    """Fewer eigenpairs than requested, or eigenpairs that do not satisfy their equation."""
