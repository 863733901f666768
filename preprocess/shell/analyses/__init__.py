"""Load cases, frequencies, buckling and their errors."""
