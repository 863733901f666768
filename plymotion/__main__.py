"""`python -m plymotion` is the command `plymotion`."""

import sys

from .solver.__main__ import main

if __name__ == "__main__":
    sys.exit(main())
