"""Episodes, sessions and robots: whose joints and transforms the assembler believes."""

from __future__ import annotations

import pytest

from fairlead.errors import MessageError
from fairlead.messages import (
    JointState,
)
from fairlead.robot.manifest import RobotManifest
from fairlead_state_assembler.branches import HISTORY_TICKS
from fairlead_state_assembler.core import AssemblerCore
from tests.assembler.robot_feed import RobotFeed, layouts


def test_older_joint_state_is_ignored(core: AssemblerCore, feed: RobotFeed) -> None:
    core.on_transforms(feed.moving(5), "hal")
    core.on_joints(feed.joints(5))
    assert core.on_joints(feed.joints(4)) == []


def test_new_episode_does_not_use_transforms_from_before_it(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    core.on_transforms(feed.moving(4), "hal")
    core.on_joints(feed.joints(4))
    feed.episode_tick = 6
    assert layouts(core.on_joints(feed.joints(6))) == []
    core.on_transforms(feed.static(6), "hal")
    [state] = layouts(core.on_transforms(feed.moving(6), "hal"))
    assert (state.tick, state.episode_tick, state.oldest_tick) == (6, 6, 6)


def test_new_session_is_answered_from_its_own_data_and_the_old_one_ignored(
    core: AssemblerCore, feed: RobotFeed, robot: RobotManifest
) -> None:
    core.on_transforms(feed.moving(9), "hal")
    core.on_joints(feed.joints(9))
    restarted = RobotFeed(robot, session=12)
    core.on_transforms(restarted.static(1), "hal")
    core.on_transforms(restarted.moving(1), "hal")
    [state] = layouts(core.on_joints(restarted.joints(1)))
    assert (state.session, state.tick, state.fault) == (12, 1, None)
    assert core.on_joints(feed.joints(10)) == []
    assert core.on_transforms(feed.moving(10), "hal") == []


def test_new_session_whose_transforms_come_first_is_never_mixed_with_the_old_joints(
    core: AssemblerCore, feed: RobotFeed, robot: RobotManifest
) -> None:
    core.on_joints(feed.joints(9))
    restarted = RobotFeed(robot, session=12)
    core.on_transforms(restarted.static(9), "hal")
    assert core.on_transforms(restarted.moving(9), "hal") == []


def test_state_of_a_session_that_the_gate_does_not_follow_changes_nothing(
    core: AssemblerCore, feed: RobotFeed, robot: RobotManifest
) -> None:
    core.on_lease(feed.lease())
    core.on_transforms(feed.moving(9), "hal")
    core.on_joints(feed.joints(9))
    stranger = RobotFeed(robot, session=12)
    assert core.on_transforms(stranger.moving(900), "hal") == []
    assert core.on_joints(stranger.joints(900)) == []
    core.on_transforms(feed.moving(10), "hal")
    [state] = layouts(core.on_joints(feed.joints(10)))
    assert (state.session, state.tick, state.fault) == (11, 10, None)


def test_session_that_was_left_is_followed_again_where_the_gate_follows_it(
    core: AssemblerCore, feed: RobotFeed, robot: RobotManifest
) -> None:
    core.on_joints(feed.joints(9))
    core.on_joints(RobotFeed(robot, session=12).joints(900))  # before the gate's first lease
    core.on_lease(feed.lease())
    core.on_transforms(feed.static(10), "hal")
    assert core.on_transforms(feed.moving(10), "hal") == []
    [state] = layouts(core.on_joints(feed.joints(10)))
    assert (state.session, state.tick, state.fault) == (11, 10, None)


def test_another_hal_beside_the_one_that_the_gate_follows_is_told(
    core: AssemblerCore, feed: RobotFeed, robot: RobotManifest
) -> None:
    core.on_lease(feed.lease())
    stranger = RobotFeed(robot, session=12)
    core.on_joints(stranger.joints(1))
    core.on_joints(stranger.joints(2))  # it may be the next HAL, of which the gate tells soon
    core.on_joints(feed.joints(9))
    with pytest.raises(MessageError) as error:
        core.on_joints(stranger.joints(3))
    assert str(error.value) == (
        "state/joints: expected session 000000000000000b, the HAL that the gate follows, got "
        "000000000000000c beside it; another HAL runs under this robot's keys"
    )


def test_next_hal_is_followed_from_the_gates_lease_on(
    core: AssemblerCore, feed: RobotFeed, robot: RobotManifest
) -> None:
    core.on_lease(feed.lease())
    core.on_joints(feed.joints(9))
    restarted = RobotFeed(robot, session=12)
    assert core.on_joints(restarted.joints(1)) == []
    core.on_lease(restarted.lease())
    core.on_transforms(restarted.static(2), "hal")
    core.on_transforms(restarted.moving(2), "hal")
    [state] = layouts(core.on_joints(restarted.joints(2)))
    assert (state.session, state.tick, state.fault) == (12, 2, None)
    assert core.on_joints(feed.joints(10)) == []  # late, and nothing to tell of


def test_next_hal_is_no_stranger_because_of_one_heard_before(
    core: AssemblerCore, feed: RobotFeed, robot: RobotManifest
) -> None:
    core.on_lease(feed.lease())
    core.on_joints(RobotFeed(robot, session=12).joints(1))
    core.on_joints(feed.joints(9))
    restarted = RobotFeed(robot, session=13)
    assert [core.on_joints(restarted.joints(tick)) for tick in (1, 2)] == [[], []]


def test_joint_state_of_another_robot_is_refused(core: AssemblerCore, feed: RobotFeed) -> None:
    good = feed.joints(1)
    other = JointState(
        session=good.session,
        tick=1,
        episode_tick=1,
        stamp_ns=0,
        positions=good.positions,
        velocities=good.velocities,
        efforts=good.efforts,
        acted=good.acted,
        robot_hash=bytes([171]) * 32,
    )
    with pytest.raises(MessageError) as error:
        core.on_joints(other)
    assert str(error.value) == (
        f"state/joints: expected robot panda_mobile ({feed.robot.robot_hash.hex()[:12]}), got "
        "abababababab; the HAL runs with another robot.yaml"
    )


def test_joint_state_of_the_wrong_width_is_refused(core: AssemblerCore, feed: RobotFeed) -> None:
    good = feed.joints(1)
    short = JointState(
        session=good.session,
        tick=1,
        episode_tick=1,
        stamp_ns=0,
        positions=good.positions[8:],
        velocities=good.velocities,
        efforts=good.efforts,
        acted=good.acted,
        robot_hash=good.robot_hash,
    )
    with pytest.raises(MessageError) as error:
        core.on_joints(short)
    assert str(error.value) == "state/joints: expected 14 positions, got 13"


FAR = 2**63


def test_one_state_of_a_far_tick_is_forgotten_with_the_gates_next_lease(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    core.on_lease(feed.lease(8))
    core.on_joints(feed.joints(FAR))
    assert core.on_joints(feed.joints(9)) == []
    core.on_lease(feed.lease(9))
    core.on_transforms(feed.moving(10), "hal")
    [state] = layouts(core.on_joints(feed.joints(10)))
    assert (state.tick, state.fault) == (10, None)


def test_an_episode_that_has_not_begun_is_refused(core: AssemblerCore, feed: RobotFeed) -> None:
    feed.episode_tick = FAR
    with pytest.raises(MessageError, match=f"tick 9: expected an episode that .* got {FAR}"):
        core.on_joints(feed.joints(9))


def test_transforms_of_far_ticks_are_forgotten_with_the_gates_next_lease(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    core.on_lease(feed.lease(8))
    core.on_joints(feed.joints(8))
    for ahead in range(2 * HISTORY_TICKS):  # as many as are kept, and more
        core.on_transforms(feed.moving(FAR + ahead), "hal")
    core.on_transforms(feed.moving(FAR, "base_link"), "localiser")  # a rival for ever
    core.on_lease(feed.lease(9))
    core.on_transforms(feed.moving(10), "hal")
    [state] = layouts(core.on_joints(feed.joints(10)))
    assert (state.tick, state.fault) == (10, None)
