"""A HAL that is asked to end leaves a robot that was told to hold, and soon."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from fairlead.hal.plan_executor import BRAKE_S, STANDS_S
from tests.hal.running_host import RunningHost, identity, move_until, wait_until

PERIOD_S = identity().period_ns * 1e-9


class EndingHost(RunningHost):
    """Its backend says what it had been told when it was closed."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.told: list[int] = []
        self.backend.close = self._on_close  # type: ignore[method-assign]

    def _on_close(self) -> None:
        self.told = list(self.backend.applied)


def test_a_hal_that_ends_in_mid_motion_commands_the_hold_before_it_lets_go(tmp_path: Path) -> None:
    host = EndingHost(tmp_path)
    move_until(host, lambda: host.backend.applied[-2:] == [1, 1])
    host.close()
    assert 1 in host.told
    held = len(host.told) - max(at for at, parts in enumerate(host.told) if parts) - 1
    assert held * PERIOD_S >= STANDS_S  # what was told last may begin only now


@pytest.mark.parametrize("also_read", [False, True])
def test_a_driver_that_refuses_the_hold_is_let_go_all_the_same(
    tmp_path: Path, also_read: bool
) -> None:
    host = EndingHost(tmp_path)
    wait_until(lambda: len(host.states) > 1)
    host.backend.hold_error = OSError("bus off")
    if also_read:
        host.backend.read_error = OSError("bus off")
    asked_s = time.monotonic()
    host.close()
    assert host.told
    assert time.monotonic() - asked_s < BRAKE_S + 2.0
