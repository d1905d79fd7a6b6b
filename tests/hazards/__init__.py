"""Hazards, the checks of the gate that answer them, and the tests that prove the checks.

``python -m tests.hazards`` prints the table of docs/safety.md; ``--write`` puts it there.
"""
