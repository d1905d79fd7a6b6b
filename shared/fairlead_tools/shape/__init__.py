"""A robot's shape: the geometry of its links, capsules around it, and which of them can meet."""

SAMPLES = 20_000
"""Random poses to look for pairs in, unless a person says another number."""
