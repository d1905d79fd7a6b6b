"""Policies behind a server: what they share, and one protocol a file (openpi, RLDX and GR00T)."""
