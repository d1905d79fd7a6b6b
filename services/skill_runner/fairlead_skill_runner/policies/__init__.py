"""Policies that ship with the runner: one class each, in a file or a folder of its own."""
