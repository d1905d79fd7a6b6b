"""Causes of stops as the campaigns count and tell them."""

from __future__ import annotations

from bench.soundness.stops import kind_of, story_of

CAUSE = "stopped: G040 arm panda_joint6: 0.38647 rad/s, limit 0.32 rad/s (measured: shares of 0.90)"


def test_stops_of_one_joint_are_counted_together_whatever_their_numbers() -> None:
    other = "stopped: G040 arm panda_joint6: 1.160305146955808, limit 0.32 (measured: so)"
    assert kind_of(CAUSE) == kind_of(other) == "G040 arm panda_joint6"


def test_the_story_of_a_stop_has_its_numbers_rounded() -> None:
    assert story_of(CAUSE) == "G040 arm panda_joint6 0.386, limit 0.32"


def test_a_cause_without_numbers_is_told_by_its_first_words() -> None:
    cause = "the HAL cannot do what was released"
    assert kind_of(cause) == story_of(cause) == cause
    assert len(story_of("stopped: G011 " + "no state " * 20)) == 60
