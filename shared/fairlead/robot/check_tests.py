"""The tests that prove the checks of motion, shape, surroundings and the gate itself, by code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from fairlead.robot.bound_tests import Enforcement

CHECK_TESTS: Mapping[str, Enforcement] = {}
"""One test for each check; a check that is not here is taken for one that does not exist."""


def proven(code: str, words: str = "") -> tuple[Enforcement, ...]:
    """The check of that code, with what it does in words where it does not simply compare."""
    if code not in CHECK_TESTS:
        return ()
    check = f"{code} {words}".rstrip()
    return (replace(CHECK_TESTS[code], check=check),)
