"""One simulator for all tests of this folder: making it takes seconds, a reset does not."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend


@pytest.fixture(scope="session")
def backend() -> Iterator[RobosuiteBackend]:
    """Every test resets it with its own seed."""
    made = RobosuiteBackend(SimulatorOptions())
    yield made
    made.close()
