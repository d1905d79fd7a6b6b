"""Hazards, the checks of the gate that answer them, and the tests that prove the checks.

``python -m tests.pages --write`` puts the table into docs/safety.md.
"""
