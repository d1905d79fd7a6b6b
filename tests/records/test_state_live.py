"""The state vector through the running processes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import LiveRobot, wait_for
from fairlead.deploy.registry import Registry
from fairlead.hal.backend import FramePose
from fairlead.messages import TransformBatch, decode, floats
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import load_skill
from fairlead.wire.bus import Sample
from fairlead_state_assembler import (
    ForwardKinematics,
    LocalAssembler,
    TransformBuffer,
    pose_from,
)
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.records.episode import Episode
from tests.repo.tree import ROOT

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]

LOCALISER = ROOT / "docs" / "examples" / "localiser.py"


def test_state_26_the_policy_sees_the_assembled_vector_and_not_the_joints(
    episode: Episode,
) -> None:
    """The policy gets what was published for that tick, bit for bit."""
    assert len(episode.calls) > 20
    for call in episode.calls:
        published = episode.layouts[call.tick]
        assert published.fault is None and published.values is not None
        assert call.state.tobytes() == published.values


def test_state_27_the_links_are_on_the_bus_and_the_assembler_publishes_them(
    episode: Episode, robot: RobotManifest
) -> None:
    """Every URDF link is published as a transform."""
    batches = episode.transforms["state_assembler"]
    children = {item.child for item in batches[episode.ticks[5]].transforms}
    assert {"panda_link0", "panda_link7", "panda_hand", "panda_hand_tcp"} <= children
    static = episode.transforms.get("state_assembler/static", {})
    children |= {item.child for batch in static.values() for item in batch.transforms}
    kinematics = ForwardKinematics(robot)
    assert set(kinematics.frames) - {robot.base_frame} <= children
    for tick in episode.ticks[::20]:
        published = TransformBuffer()
        for batch in (*static.values(), batches[tick]):
            for item in batch.transforms:
                pose = pose_from(item.child, floats(item.translation), floats(item.rotation_xyzw))
                published.add(item.parent, item.child, pose, tick, is_static=batch.is_static)
        truth = kinematics.poses(episode.joints[tick])
        for frame, place in kinematics.frames.items():
            found = published.at(tick).pose(robot.base_frame, frame)
            np.testing.assert_allclose(found.homogeneous, truth[place].homogeneous, atol=1e-9)


def test_state_28_the_hal_alone_says_where_the_base_is(episode: Episode) -> None:
    """odom -> base_link comes from the HAL alone, every tick."""
    for tick in episode.ticks:
        links = {(t.parent, t.child) for t in episode.transforms["hal"][tick].transforms}
        assert ("odom", "base_link") in links
    others = {
        t.child
        for name, batches in episode.transforms.items()
        if not name.startswith("hal")
        for batch in batches.values()
        for t in batch.transforms
    }
    assert "base_link" not in others


def test_state_29_a_missing_frame_fails_the_goal_at_its_first_step_by_name(
    light_robot: LiveRobot,
) -> None:
    """A missing frame fails the goal by name; nothing moves."""
    before = len(light_robot.motion.read())
    result = light_robot.run_goal(seed=0)
    assert (result.outcome, result.kind) == ("failed", "layout_missing_frame"), result
    assert "no frame 'object'" in result.detail, result
    assert not any(line.moves for line in light_robot.motion.read()[before:])


def test_state_30_any_hal_that_publishes_joints_and_transforms_is_enough(
    light_robot: LiveRobot, robot: RobotManifest
) -> None:
    """Joints and transforms alone make the vector."""
    skill = "pi05-robocasa365-human300-nf4"
    bus, keys = light_robot.client.bus, light_robot.client.keys
    heard = Episode()
    subscriptions = [
        bus.subscribe(keys.layout(skill), heard.on_layout),
        bus.subscribe(keys.joints, heard.on_joints),
        bus.subscribe(keys.tf("hal"), heard.on_transforms),
    ]
    wanted = bus.declare_token(keys.want_layout(skill))
    light_robot.client.reset_episode(0)
    wait_for(lambda: heard_whole(heard) is not None, "a state vector and all that it is made of")
    for one in (wanted, *subscriptions):
        one.undeclare()
    tick = heard_whole(heard)
    assert tick is not None
    static = next(iter(heard.transforms["hal/static"].values()))
    assembler = LocalAssembler(robot)
    moving = heard.transforms["hal"][tick]
    assembler.take(heard.joints[tick], frame_poses(moving), frame_poses(static))
    local = assembler.assemble(load_skill(skill).state_contract)
    assert heard.layouts[tick].values == local.tobytes()
    assert local.shape == (16,) and np.linalg.norm(local[:3]) > 0.3, "the hand is off the base"


def heard_whole(heard: Episode) -> int | None:
    """A tick of which everything was heard; None so far."""
    ticks = heard.joints.keys() & heard.transforms.get("hal", {}).keys()
    told = [tick for tick, layout in heard.layouts.items() if layout.values and tick in ticks]
    return told[0] if told and "hal/static" in heard.transforms else None


def frame_poses(batch: TransformBatch) -> list[FramePose]:
    return [
        FramePose(t.parent, t.child, floats(t.translation), floats(t.rotation_xyzw))
        for t in batch.transforms
    ]


def test_state_33_a_localiser_says_where_odom_is_and_the_hal_then_does_not(tmp_path: Path) -> None:
    """map -> odom comes from the named localiser; without it goals fail."""
    options = ScratchOptions(hal=LIGHT_HAL, localiser="amcl")
    scratch = make_scratch(ROOT / "compose" / "panda_mobile_sim.yaml", tmp_path / "state", options)
    sent: set[str] = set()

    def on_transforms(sample: Sample) -> None:
        sent.update(one.child for one in decode(TransformBatch, sample.payload).transforms)

    with scratch_robot(scratch, Registry(tmp_path / "registry")) as running:
        live = LiveRobot(running, skill="go-to")  # which asks where the base is in map
        live.client.bus.subscribe(live.client.keys.tf("hal"), on_transforms)
        wait_for(lambda: "base_link" in sent, "transforms of the HAL")
        missing = live.run_goal(seed=0)
        assert missing.kind == "layout_missing_frame", missing
        assert "amcl has not sent 'odom' (tf/amcl)" in missing.detail
        words = [str(LOCALISER), str(scratch.file), "amcl", "5", "0"]
        with subprocess.Popen([sys.executable, *words]) as localiser:
            wait_for(lambda: live.run_goal(seed=0).kind == "bad_goal", "the policy is asked")
            localiser.terminate()
    assert "odom" not in sent
