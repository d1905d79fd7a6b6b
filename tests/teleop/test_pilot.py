"""What becomes of a deflection: rows that begin where the robot is and end at rest."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fairlead.messages import FloatArray
from fairlead_tools.teleop.device import Deflection
from fairlead_tools.teleop.drive import Drive
from fairlead_tools.teleop.pilot import Pilot
from tests.teleop.drives import asks, drive

PANDA = drive()
TOOL = drive("ur5e", "arm", "cartesian_delta")
BASE = drive("panda_mobile", "base")
START = np.array([0.0, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785])
FIRST = asks(1, 0, 0, 0, 0, 0, 0)
IDLE = asks(0, 0, 0, 0, 0, 0, 0)
SILENCE_S = 0.2


class Driven:
    """A pilot whose rows are all released, and a robot that is where its rows say."""

    def __init__(self, driven: Drive, ahead: int = 0, start: FloatArray = START) -> None:
        self.pilot = Pilot(driven, ahead=ahead, horizon=64, silence_s=SILENCE_S)
        self.tick, self.at, self.is_held = 10, start, True
        self.rows = np.zeros((0, 0))

    def drives(self, asked: Deflection, ticks: int = 1, released: int = 64) -> FloatArray:
        """The first row sent for the tick, and for each after it, ``[ticks, n]``.

        ``released``: so many rows of each chunk.
        """
        acted = []
        for _ in range(ticks):
            self.rows = self.pilot.rows(self.tick, self.at, self.is_held, asked)
            self.pilot.judged(self.tick + released - 1 if released else 0)
            acted.append(self.rows[0])
            self.at = self.rows[0] if released else self.at
            self.tick, self.is_held = self.tick + 1, not released
        return np.array(acted)


@pytest.mark.parametrize("ahead", [0, 1])
def test_the_first_row_is_where_the_robot_is_whatever_is_asked(ahead: int) -> None:
    driven = Driven(PANDA, ahead)
    driven.drives(FIRST)
    np.testing.assert_array_equal(driven.rows[: 1 + ahead], [START] * (1 + ahead))


@pytest.mark.parametrize(
    "still",
    [
        IDLE,
        asks(1, 0, 0, 0, 0, 0, 0, clutch=False),
        asks(1, 0, 0, 0, 0, 0, 0, age_s=SILENCE_S * 1.001),
        asks(math.nan, 1, 0, 0, 0, 0, 0),
        asks(1, 0, 0, 0, 0, 0, 0, speed=0.0),
    ],
)
def test_nothing_moves_without_clutch_or_word_of_the_device(still: Deflection) -> None:
    driven = Driven(PANDA)
    driven.drives(still, 20)
    np.testing.assert_array_equal(driven.rows, np.tile(START, (len(driven.rows), 1)))


@pytest.mark.parametrize("ahead", [0, 1])
@pytest.mark.parametrize("driven_by", [PANDA, TOOL, BASE], ids=["joints", "tool", "base"])
def test_rows_speed_up_and_slow_down_by_no_more_than_the_drive_allows(
    driven_by: Drive, ahead: int
) -> None:
    size = len(driven_by.names)
    start = START if driven_by.is_position else np.zeros(size)
    driven = Driven(driven_by, ahead, start)
    wild = np.random.default_rng(1)
    sent = [start, start]
    for _ in range(200):
        asked = asks(*wild.uniform(-3, 3, size), clutch=bool(wild.random() < 0.8))
        sent.append(driven.drives(asked, 1)[0])
        assert driven.rows.shape[1] == size
    speeds = np.diff(sent, axis=0) if driven_by.is_position else np.array(sent)
    assert (np.abs(speeds) <= driven_by.full * (1 + 1e-9)).all()
    assert (np.abs(np.diff(speeds, axis=0)) <= driven_by.change * (1 + 1e-9)).all()
    if not driven_by.is_position:
        linear = [index for index, unit in enumerate(driven_by.units) if unit == "m"]
        norms = np.linalg.norm(speeds[:, linear], axis=1)
        assert norms.max() <= driven_by.full[0] * math.sqrt(3) and norms.max() > 0


@pytest.mark.parametrize("ahead", [0, 1])
def test_every_chunk_ends_at_rest(ahead: int) -> None:
    driven = Driven(PANDA, ahead)
    driven.drives(FIRST, 12)
    speeds = np.diff(driven.rows, axis=0)[:, 0]
    assert speeds[0] > 0
    assert speeds[-1] == pytest.approx(0.0, abs=1e-12)
    led = Driven(TOOL, ahead, np.zeros(6))
    led.drives(asks(1, 0, 0, 0, 0, 0), 12)
    assert led.rows[0][0] == pytest.approx(TOOL.full[0])
    assert led.rows[-1] == pytest.approx(np.zeros(6), abs=1e-12)


def test_a_device_that_falls_silent_stops_within_the_bound_that_the_drive_gives() -> None:
    driven = Driven(PANDA, ahead=1)
    driven.drives(FIRST, 12)
    driven.drives(asks(1, 0, 0, 0, 0, 0, 0, age_s=SILENCE_S * 1.01))
    bound = 1 + math.ceil(PANDA.full[0] / PANDA.change[0])
    driven.drives(asks(1, 0, 0, 0, 0, 0, 0, age_s=1.0), bound)
    assert driven.pilot.at_rest


def test_rows_that_may_have_acted_are_repeated() -> None:
    driven = Driven(PANDA, ahead=1)
    driven.drives(FIRST, 6)
    planned = driven.rows[1]
    driven.drives(asks(-1, 0, 0, 0, 0, 0, 0))
    np.testing.assert_array_equal(driven.rows[0], planned)
    assert driven.rows[1][0] < 2 * planned[0] - driven.at[0] + PANDA.full[0]


def test_after_a_hold_it_begins_anew_from_where_the_robot_is() -> None:
    driven = Driven(PANDA)
    driven.drives(FIRST, 6)
    elsewhere = START + 0.01
    driven.at, driven.is_held = elsewhere, True
    np.testing.assert_array_equal(driven.drives(FIRST)[0], elsewhere)


def test_after_a_refusal_the_rows_released_before_are_gone_on_from() -> None:
    driven = Driven(PANDA, ahead=1)
    driven.drives(FIRST, 6)
    older = driven.rows
    driven.pilot.rows(driven.tick, driven.at, False, FIRST)
    driven.pilot.judged(0)
    after = driven.pilot.rows(driven.tick, driven.at, False, IDLE)
    np.testing.assert_array_equal(after[0], older[1])


def test_of_a_truncated_chunk_only_what_was_released_is_gone_on_from() -> None:
    driven = Driven(PANDA)
    driven.drives(FIRST, 5)
    last = driven.drives(FIRST, 1, released=1)[0]
    assert driven.drives(FIRST)[0][0] > last[0]
    driven.drives(FIRST, 1, released=1)
    beyond = driven.pilot.rows(driven.tick + 1, driven.at, False, FIRST)
    np.testing.assert_array_equal(beyond[0], driven.at)


def test_a_joint_comes_to_rest_before_its_limit_and_is_not_drawn_back() -> None:
    near = START.copy()
    near[0] = PANDA.upper[0] - 0.2
    driven = Driven(PANDA, start=near)
    way = driven.drives(FIRST, 200)[:, 0]
    assert way.max() <= PANDA.upper[0] and way[-1] == pytest.approx(PANDA.upper[0], abs=1e-3)
    assert (np.diff(way) >= 0).all()


def test_a_joint_that_does_not_follow_is_waited_for() -> None:
    driven = Driven(PANDA)
    for _ in range(40):
        driven.rows = driven.pilot.rows(driven.tick, START, driven.is_held, FIRST)
        driven.pilot.judged(driven.tick + 9)
        driven.tick, driven.is_held = driven.tick + 1, False
    assert (driven.rows[:, 0] - START[0]).max() == pytest.approx(PANDA.lead[0])


def test_a_joint_a_little_beyond_its_limit_is_driven_off_it() -> None:
    above = START.copy()
    above[0] = PANDA.upper[0] + 2e-5
    driven = Driven(PANDA, start=above)
    rows = driven.drives(asks(-1, 0, 0, 0, 0, 0, 0), ticks=5)
    assert rows[:, 0].max() == PANDA.upper[0]
    assert rows[-1, 0] < PANDA.upper[0]
