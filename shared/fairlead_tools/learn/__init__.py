"""Policies that learn from a scripted expert: recording, exporting, training."""
