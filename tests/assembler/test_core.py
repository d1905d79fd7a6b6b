"""When the assembler answers, waits, repeats itself and gives up."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from fairlead.hal.backend import FramePose
from fairlead.messages import (
    NO_HASH,
    LayoutState,
    TransformBatch,
    decode,
    floats,
    pack_floats,
)
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import load_skill
from fairlead_state_assembler import ForwardKinematics, LocalAssembler
from fairlead_state_assembler.core import AssemblerCore, Output
from fairlead_state_assembler.publishers import Publishers
from fairlead_state_assembler.skill_view import SkillView
from tests.assembler.robot_feed import SKILL, RobotFeed, layouts


def links(outputs: list[Output]) -> list[TransformBatch]:
    return [decode(TransformBatch, item.payload) for item in outputs if item.skill is None]


def test_nothing_is_published_before_the_first_joint_state(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    assert core.on_transforms(feed.moving(1), "hal") == []


def test_joints_after_transforms_are_answered_at_once(core: AssemblerCore, feed: RobotFeed) -> None:
    core.on_transforms(feed.moving(1), "hal")
    outputs = core.on_joints(feed.joints(1))
    assert [item.skill for item in outputs] == [SKILL, None]
    [state] = layouts(outputs)
    skill = load_skill(SKILL)
    assert (state.session, state.tick, state.episode_tick, state.oldest_tick) == (11, 1, 1, 1)
    assert (state.skill, state.skill_hash, state.layout) == (
        SKILL, skill.skill_hash, "mobile_pick_30d",
    )  # fmt: skip
    assert state.fault is None
    assert state.values is not None
    assert len(floats(state.values)) == 30


def test_service_and_local_assembler_agree_bit_for_bit(
    core: AssemblerCore, feed: RobotFeed, robot: RobotManifest
) -> None:
    core.on_transforms(feed.moving(1), "hal")
    [state] = layouts(core.on_joints(feed.joints(1)))

    def frame_poses(batch: TransformBatch) -> list[FramePose]:
        return [
            FramePose(t.parent, t.child, floats(t.translation), floats(t.rotation_xyzw))
            for t in batch.transforms
        ]

    local = LocalAssembler(robot)
    local.take(
        np.array(feed.positions(1)), frame_poses(feed.moving(1)), frame_poses(feed.static(1))
    )
    assert state.values == pack_floats(local.assemble(load_skill(SKILL).state_contract))


def test_link_transforms_are_the_forward_kinematics_of_the_tick(
    core: AssemblerCore, feed: RobotFeed, robot: RobotManifest
) -> None:
    [batch] = links(core.on_joints(feed.joints(3)))
    kinematics = ForwardKinematics(robot)
    poses = kinematics.poses(np.array(feed.positions(3)))
    assert (batch.session, batch.tick, batch.is_static) == (11, 3, False)
    assert [item.child for item in batch.transforms] == list(kinematics.frames)
    for item in batch.transforms:
        assert item.parent == "base_link"
        numbers = np.concatenate((floats(item.translation), floats(item.rotation_xyzw)))
        assert np.array_equal(numbers, pin.SE3ToXYZQUAT(poses[kinematics.frames[item.child]])), (
            item.child
        )


def test_joints_before_transforms_wait_and_are_answered_when_they_come(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    assert layouts(core.on_joints(feed.joints(1))) == []
    [state] = layouts(core.on_transforms(feed.moving(1), "hal"))
    assert (state.tick, state.fault) == (1, None)


def test_transform_missing_until_the_next_joints_is_a_fault_naming_frame_parent_and_age(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    core.on_transforms(feed.moving(1), "hal")
    core.on_joints(feed.joints(1))
    assert layouts(core.on_joints(feed.joints(2))) == []
    [state] = layouts(core.on_joints(feed.joints(3)))
    assert (state.tick, state.values) == (2, None)
    assert state.fault is not None
    assert (state.fault.kind, state.fault.name, state.fault.parent, state.fault.age_ticks) == (
        "stale_frame", "base_link", "odom", 1,
    )  # fmt: skip
    assert state.fault.text == (
        "transforms: odom -> base_link (from hal) is stale at tick 2: the newest before it is 1 "
        "tick(s) old, allowed 0"
    )


def test_frame_that_was_never_published_is_a_fault_at_the_next_joints(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    core.on_transforms(feed.moving(1, "base_link", "object"), "hal")
    core.on_joints(feed.joints(1))
    core.on_transforms(feed.moving(2, "base_link", "object"), "hal")
    [state] = layouts(core.on_joints(feed.joints(2)))
    assert state.fault is not None
    assert (state.tick, state.fault.kind, state.fault.name, state.fault.parent) == (
        1, "missing_frame", "goal", "base_site",
    )  # fmt: skip


def test_transform_lost_once_is_interpolated_when_the_next_one_comes(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    core.on_transforms(feed.moving(1), "hal")
    core.on_joints(feed.joints(1))
    assert layouts(core.on_joints(feed.joints(2))) == []
    [state] = layouts(core.on_transforms(feed.moving(3), "hal"))
    assert (state.tick, state.oldest_tick, state.fault) == (2, 1, None)


def test_two_lost_ticks_in_a_row_make_one_fault(core: AssemblerCore, feed: RobotFeed) -> None:
    core.on_transforms(feed.moving(1), "hal")
    core.on_joints(feed.joints(1))
    core.on_joints(feed.joints(2))
    [state] = layouts(core.on_joints(feed.joints(3)))
    assert (state.tick, state.values) == (2, None)
    assert layouts(core.on_transforms(feed.moving(4), "hal")) == []
    [state] = layouts(core.on_joints(feed.joints(4)))
    assert (state.tick, state.fault) == (4, None)


def test_frame_that_its_publisher_sends_no_more_is_a_fault_at_once(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    core.on_transforms(feed.moving(1), "hal")
    core.on_joints(feed.joints(1))
    core.on_transforms(feed.moving(2, "base_link", "goal"), "hal")
    [state] = layouts(core.on_joints(feed.joints(2)))
    assert (state.tick, state.values) == (2, None)
    assert state.fault is not None
    assert (state.fault.kind, state.fault.name, state.fault.age_ticks) == (
        "stale_frame", "object", 1,
    )  # fmt: skip
    assert state.fault.text == (
        "transforms: odom -> object (from hal) is stale at tick 2: the newest before it is 1 "
        "tick(s) old, allowed 0; hal sends its transforms without it now"
    )


def test_another_publishers_batch_says_nothing_of_a_frame(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    core.on_transforms(feed.moving(1, "base_link", "goal"), "hal")
    core.on_transforms(feed.moving(1, "object"), "tracker")
    core.on_joints(feed.joints(1))
    core.on_transforms(feed.moving(2, "base_link", "goal"), "hal")
    assert layouts(core.on_joints(feed.joints(2))) == []
    [state] = layouts(core.on_transforms(feed.moving(2, "object"), "tracker"))
    assert (state.tick, state.fault) == (2, None)


def test_loop_is_a_fault_at_once(core: AssemblerCore, feed: RobotFeed) -> None:
    core.on_transforms(feed.looped(1), "hal")
    [state] = layouts(core.on_joints(feed.joints(1)))
    assert state.fault is not None
    assert (state.tick, state.fault.kind) == (1, "loop")


def test_repeated_tick_is_answered_with_the_identical_bytes(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    core.on_transforms(feed.moving(1), "hal")
    first = core.on_joints(feed.joints(1))
    assert core.on_transforms(feed.moving(1), "hal") == []
    assert core.on_joints(feed.joints(1)) == first
    assert core.on_joints(feed.joints(1)) == first


def test_lockstep_fault_comes_with_the_second_repeat_and_again_with_each_later_one(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    assert layouts(core.on_joints(feed.joints(1))) == []
    assert layouts(core.on_joints(feed.joints(1))) == []
    for _ in range(2):
        [state] = layouts(core.on_joints(feed.joints(1)))
        assert state.fault is not None
        assert (state.fault.kind, state.fault.name, state.fault.parent) == (
            "missing_frame", "base_link", "odom",
        )  # fmt: skip


def test_fault_is_no_answer_the_layout_follows_when_the_transforms_come(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    for _ in range(3):
        outputs = core.on_joints(feed.joints(1))
    assert layouts(outputs)[0].fault is not None
    [state] = layouts(core.on_transforms(feed.moving(1), "hal"))
    assert (state.tick, state.fault) == (1, None)
    assert layouts(core.on_joints(feed.joints(1))) == [state]


def test_skill_wanted_while_the_world_waits_is_answered_for_the_current_tick(
    robot: RobotManifest, feed: RobotFeed
) -> None:
    core = AssemblerCore(robot, Publishers())
    core.on_transforms(feed.static(1), "hal")
    core.on_transforms(feed.moving(1), "hal")
    assert layouts(core.on_joints(feed.joints(1))) == []
    outputs = core.want(SkillView(SKILL))
    assert [state.tick for state in layouts(outputs)] == [1]


def test_skill_no_longer_wanted_is_no_longer_assembled(
    core: AssemblerCore, feed: RobotFeed
) -> None:
    core.unwant(SKILL)
    core.on_transforms(feed.moving(1), "hal")
    assert [item.skill for item in core.on_joints(feed.joints(1))] == [None]


def test_unknown_skill_is_a_fault_at_every_tick(robot: RobotManifest, feed: RobotFeed) -> None:
    core = AssemblerCore(robot, Publishers())
    view = SkillView("no-such-skill")
    outputs = core.want(view)
    assert outputs == []
    assert str(view.refusal).startswith("skill 'no-such-skill': no file ")
    core.on_joints(feed.joints(1))
    [state, _] = core.on_joints(feed.joints(2))
    fault = decode(LayoutState, state.payload)
    assert fault.skill_hash == NO_HASH
    assert fault.fault is not None
    assert (fault.fault.kind, fault.fault.name) == ("unknown_skill", "no-such-skill")
    assert fault.fault.text == str(view.refusal)


def test_slow_localiser_is_used_up_to_its_declared_age(
    robot: RobotManifest, feed: RobotFeed
) -> None:
    core = AssemblerCore(robot, Publishers(), {"goal": 5})
    core.want(SkillView(SKILL))
    core.on_transforms(feed.static(1), "hal")
    core.on_transforms(feed.moving(1, "goal"), "tracker")
    for tick in range(1, 7):
        core.on_transforms(feed.moving(tick, "base_link", "object"), "hal")
        [state] = layouts(core.on_joints(feed.joints(tick)))
        assert (state.tick, state.oldest_tick, state.fault) == (tick, 1, None)
    core.on_transforms(feed.moving(7, "base_link", "object"), "hal")
    assert layouts(core.on_joints(feed.joints(7))) == []
    [state] = layouts(core.on_joints(feed.joints(8)))
    assert state.fault is not None
    assert (state.fault.kind, state.fault.name, state.fault.age_ticks) == ("stale_frame", "goal", 6)
