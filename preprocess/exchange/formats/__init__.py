"""One file for each format of another code: what it reads, and what it writes."""
