"""A HAL process in either pacing, for the tests of what it does on a bus."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.hal.hal_process import HalProcess


@pytest.fixture
def realtime(tmp_path: Path) -> Iterator[HalProcess]:
    hal = HalProcess(tmp_path, "realtime")
    yield hal
    hal.close()


@pytest.fixture
def lockstep(tmp_path: Path) -> Iterator[HalProcess]:
    hal = HalProcess(tmp_path, "lockstep", trace=True)
    yield hal
    hal.close()
