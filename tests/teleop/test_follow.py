"""What a leader's pose asks of its follower: no jump, no speed that nobody set, no old pose."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead.messages import FloatArray
from fairlead_tools.teleop.device import Deflection
from fairlead_tools.teleop.follow import ALIGNED_RAD, AWAY_RAD, SILENCE_S, Following, Pose
from fairlead_tools.teleop.pilot import Pilot
from tests.teleop.drives import drive

ARM = drive("so101")
PERIOD_S = 0.02
HOME = np.array([0.0, -1.0, 0.9, 0.7, 0.0])
ELSEWHERE = HOME + np.array([0.5, 0.3, -0.4, 0.0, 0.2])
SPEED = 0.3


class Pair:
    """A leader that is read before each tick, and a follower that is where its rows say."""

    def __init__(self, leader: FloatArray = HOME, speed: float = SPEED) -> None:
        self.speed = speed
        self.following = Following(ARM)
        self.pilot = Pilot(ARM, ahead=1, horizon=64, silence_s=SILENCE_S)
        self.leader, self.trigger, self.at = leader, 0.5, HOME
        self.tick, self.now_s, self.clutch, self.is_read = 10, 1.0, True, True
        self.asked = Deflection(())

    def drives(self, ticks: int = 1) -> FloatArray:
        """Where the follower is after each tick, ``[ticks, n]``."""
        way = []
        for _ in range(ticks):
            self.tick, self.now_s = self.tick + 1, self.now_s + PERIOD_S
            if self.is_read:
                self.following.hears(Pose(self.leader, self.trigger, self.now_s))
            else:
                self.following.misses("servo 3 (elbow_flex) does not answer")
            said = Deflection((), clutch=self.clutch, speed=self.speed)
            at = self.pilot.commanded(self.tick, self.at)
            self.asked = self.following.read(said, self.now_s, at)
            if self.following.lets_go:
                self.clutch = False
            rows = self.pilot.rows(self.tick, self.at, False, self.asked)
            self.pilot.judged(self.tick + len(rows) - 1)
            self.at = rows[0]
            way.append(self.at)
        return np.array(way)


def speeds(way: FloatArray) -> FloatArray:
    return np.abs(np.diff(way, axis=0))


@pytest.mark.parametrize("speed", [SPEED, 1.0])
def test_the_way_to_the_leader_is_gone_at_the_speed_that_was_set_and_without_overshoot(
    speed: float,
) -> None:
    pair = Pair(ELSEWHERE, speed)
    way = pair.drives(10)
    assert pair.asked.note == "aligning with the leader"
    way = np.vstack([[HOME], way, pair.drives(100)])
    far = np.abs(way[:-1] - ELSEWHERE).max(axis=1) > ALIGNED_RAD
    assert (speeds(way)[far] <= speed * ARM.full * (1 + 1e-9)).all()
    assert pair.asked.note == "follows the leader"
    np.testing.assert_allclose(pair.at, ELSEWHERE, atol=1e-6)
    towards = np.sign(ELSEWHERE - HOME)
    assert (towards * (way - ELSEWHERE) <= 1e-9).all()
    assert (np.abs(np.diff(way, n=2, axis=0)) <= ARM.change * (1 + 1e-9)).all()


def test_once_aligned_it_follows_as_fast_as_the_leader_moves() -> None:
    pair = Pair()
    pair.drives(5)
    behind = []
    for tick in range(100):  # 1 rad/s and back: above the speed that was set
        pair.leader = HOME + 0.5 * np.sin(2.0 * tick * PERIOD_S)
        pair.drives()
        behind.append(np.abs(pair.at - pair.leader).max())
    assert SPEED * ARM.full[0] / PERIOD_S < 1.0
    assert max(behind) < 0.12 and pair.asked.note == "follows the leader"


def test_a_leader_that_runs_away_is_approached_anew() -> None:
    pair = Pair()
    pair.drives(5)
    for _ in range(20):
        pair.leader = pair.leader + 0.1  # 5 rad/s
        pair.drives()
    assert np.abs(pair.at - pair.leader).max() > AWAY_RAD
    assert pair.asked.note == "aligning with the leader"
    way = pair.drives(20)[10:]
    assert (speeds(way) <= SPEED * ARM.full * (1 + 1e-9)).all()


def test_a_leader_that_stands_still_is_no_fault() -> None:
    pair = Pair(ELSEWHERE)
    pair.drives(1000)
    assert pair.asked.clutch and pair.asked.note == "follows the leader"
    pair.leader = ELSEWHERE - 0.1
    assert np.abs(pair.drives(10)[-1] - ELSEWHERE).max() > 0.02


def test_beyond_the_followers_range_it_goes_to_its_end() -> None:
    pair = Pair(np.array([2.0, -1.0, 0.9, 0.7, 0.0]))
    assert pair.drives(600)[-1][0] == pytest.approx(ARM.upper[0], abs=1e-3)


def test_one_that_cannot_be_read_holds_the_follower_until_the_clutch_is_let_in_again() -> None:
    pair = Pair(ELSEWHERE)
    pair.drives(20)
    pair.is_read = False
    pair.drives(round(SILENCE_S / PERIOD_S) + 2)
    wanted = "leader: servo 3 (elbow_flex) does not answer; holding, let the clutch in again"
    assert (pair.asked.note, pair.clutch) == (wanted, False)
    rest = pair.drives(30)[10:]
    assert (speeds(rest) == 0.0).all(), "it has slowed down"
    pair.is_read, pair.leader = True, HOME
    np.testing.assert_array_equal(pair.drives(100), np.tile(rest[-1], (100, 1)))
    pair.clutch = True
    assert (speeds(pair.drives(10)) <= SPEED * ARM.full * (1 + 1e-9)).all()
    assert pair.asked.note == "aligning with the leader"


def test_the_clutch_let_in_while_it_cannot_be_read_takes_over_and_holds() -> None:
    pair = Pair()
    pair.is_read = False
    pair.drives()
    assert (pair.asked.clutch, pair.clutch) == (True, False)
    np.testing.assert_array_equal(pair.drives(20), np.tile(HOME, (20, 1)))


def test_a_leap_that_no_hand_can_make_is_not_followed() -> None:
    pair = Pair()
    pair.drives(5)
    pair.leader = HOME + np.array([0.0, 0.0, 1.0, 0.0, 0.0])
    pair.drives()
    assert pair.asked.note.startswith("leader: elbow_flex leapt by 1.00 rad; holding")
    np.testing.assert_array_equal(pair.drives(50), np.tile(HOME, (50, 1)))


def test_the_gripper_is_told_nothing_before_the_trigger_moves() -> None:
    pair = Pair()
    pair.drives(5)
    assert pair.asked.opening is None
    pair.trigger = 0.6
    pair.drives()
    assert pair.asked.opening == 0.6
    pair.trigger = 0.5
    pair.drives()
    assert pair.asked.opening == 0.5
    pair.clutch = False
    pair.drives()
    pair.clutch = True
    pair.drives()
    assert pair.asked.opening is None
