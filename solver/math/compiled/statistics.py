"""What a process has compiled, and what it has found in the cache."""


class Statistics:
    """Names of functions, once for each set of argument types."""

    def __init__(self) -> None:
        self.compiled: list[str] = []
        self.loaded: list[str] = []
        self.fallbacks: list[str] = []  # compiled by numba.njit
        self.kept = True  # the cache could be written
        self.load_s = 0.0  # CPU time for all of them


statistics = Statistics()
