"""Descriptions of laminated shells."""
