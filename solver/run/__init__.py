"""One run of a mechanism: prepare, integrate, judge, write."""
