"""`python -m plymotion` is the command `plymotion`."""

import sys

try:
    from .solver.system.interrupts import begin_program
except KeyboardInterrupt:
    sys.exit(130)


def main() -> int:
    """Run the command line."""
    begin_program()
    from .solver.__main__ import main as command

    return command()


if __name__ == "__main__":
    sys.exit(main())
