"""The two functions of the modal package file: write_package and read_package."""

from .reader import read_package
from .writer import write_package

__all__ = ["read_package", "write_package"]
