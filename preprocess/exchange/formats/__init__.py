"""One file for each format of another code; contract.py says what a file supplies."""
