"""The modal package of a flexible body (docs/format.md)."""
