"""Policies that ship with the runner; each is one file with one class."""
