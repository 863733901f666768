"""Optimisers: one file each, found by this folder."""
