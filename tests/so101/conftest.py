"""An emulated arm for a module, and as it is after it was switched on for each test."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.equipment.emulated_arm import EmulatedArm, emulated_arm
from tests.so101.arm import HOME, as_delivered


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmulatedArm]:
    with emulated_arm(tmp_path_factory.mktemp("arm")) as found:
        for servo_id, position in enumerate(HOME, start=1):  # a hand that stays
            found.order(f"pull {servo_id} {position}")
        yield found


@pytest.fixture
def sound(arm: EmulatedArm) -> EmulatedArm:
    """As it is after it was switched on."""
    calm = [f"temperature {one} 30" for one in range(1, 7)]
    for line in ("plug", "noise 0", "lose 0", "deaf 0", "late 0 0", "voltage 12", *calm, "dip"):
        assert arm.order(line) == f"done: {line}"
    return arm


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return as_delivered(tmp_path)
