"""What is tried again: in realtime the gate rightly stops a robot whose machine is too busy."""

from __future__ import annotations

import pytest

LATE = pytest.mark.flaky(
    reruns=2, only_rerun=["state_timeout_ms", "observation too new", "claim of measure lost"]
)
"""A mark: the failure has to say so. Whose bound is at stake measures the machine beside it."""
