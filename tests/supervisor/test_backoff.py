"""How long the supervisor waits before it starts a service again."""

from __future__ import annotations

from fairlead_tools.supervisor.slot import (
    FIRST_DELAY_S,
    FORGIVEN_AFTER_S,
    LONGEST_DELAY_S,
    Backoff,
)


def test_delays_double_up_to_the_longest() -> None:
    backoff = Backoff()
    delays = [backoff.delay_s(0.1) for _ in range(7)]
    assert delays == [0.5, 1.0, 2.0, 4.0, 8.0, 10.0, 10.0]
    assert (delays[0], delays[-1]) == (FIRST_DELAY_S, LONGEST_DELAY_S)


def test_a_long_life_is_forgiven() -> None:
    backoff = Backoff()
    for _ in range(5):
        backoff.delay_s(0.1)
    assert backoff.delay_s(FORGIVEN_AFTER_S) == FIRST_DELAY_S


def test_a_life_just_too_short_is_not_forgiven() -> None:
    backoff = Backoff()
    backoff.delay_s(0.1)
    assert backoff.delay_s(FORGIVEN_AFTER_S - 1e-9) == 2 * FIRST_DELAY_S
