"""The action vector through the whole system: from the policy's floats to `env.step`."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from fairlead.messages import FloatArray, floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.parity import plain_robosuite
from tests.records.episode import SEED, Episode

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]

TORSO, SWITCH = 10, 11
NEAR_M, NEAR_BY = 0.10, 220


def executed(episode: Episode) -> FloatArray:
    """What `env.step` was given in each tick of the goal, ``[ticks, 12]``."""
    return np.array([episode.packed[tick] for tick in episode.ticks])


def emitted(episode: Episode) -> FloatArray:
    """What the policy said for each of these ticks, ``[ticks, 12]``."""
    rows: dict[int, FloatArray] = {}
    for call in episode.calls:
        rows |= {call.tick + index: row for index, row in enumerate(call.actions)}
    return np.array([rows[tick] for tick in episode.ticks])


def test_action_33_every_number_reaches_the_simulator_as_the_policy_wrote_it_but_the_torso(
    episode: Episode,
) -> None:
    """Every number but the torso's reaches the simulator bit for bit."""
    wanted = emitted(episode).astype("<f4")
    wanted[:, TORSO] = 0.0
    assert executed(episode).astype("<f4").tobytes() == wanted.tobytes()


def test_action_34_the_torsos_number_is_zero_in_every_tick(episode: Episode) -> None:
    """The torso's number is zero in every tick."""
    assert not executed(episode)[:, TORSO].any()


def test_action_35_the_vector_is_noted_before_the_simulator_turns_it(episode: Episode) -> None:
    """The log has the vector before robosuite turns it."""
    base = executed(episode)[:, 7:10]
    assert np.abs(base).max() > 0.3
    assert base.astype("<f4").tobytes() == emitted(episode)[:, 7:10].astype("<f4").tobytes()


def test_action_36_the_gate_gets_typed_parts_in_si_and_never_a_raw_vector(
    episode: Episode, robot: RobotManifest
) -> None:
    """A chunk has arm, gripper, base, switch, each in SI."""
    calls = {call.tick: call.actions for call in episode.calls}
    assert {chunk.start_tick for chunk in episode.chunks} == set(calls)
    for chunk in episode.chunks:
        emitted = calls[chunk.start_tick]
        parts = {robot.part_names[part.part]: part for part in chunk.parts}
        assert {name: ControlMode(part.mode).yaml_name for name, part in parts.items()} == {
            "arm": "cartesian_delta",
            "gripper": "gripper_position",
            "base": "joint_velocity",
            "composite": "composite_mode",
        }
        assert parts["arm"].frame_id == "base_link"
        base = floats(parts["base"].values, 11)
        assert parts["base"].active == (0, 1, 2) and not base[:, 3:].any()
        np.testing.assert_allclose(base[:, :3], emitted[:, 7:10] * [1.0, 1.0, 1.5])
        arm = floats(parts["arm"].values, 6)
        np.testing.assert_allclose(arm, emitted[:, :6] * [0.05, 0.05, 0.05, 0.5, 0.5, 0.5])


def test_action_43_plain_robosuite_is_moved_alike_to_the_last_bit(episode: Episode) -> None:
    """A bare env.step loop gives every state, bit for bit."""
    vectors = emitted(episode).astype("<f4")
    vectors[:, TORSO] = 0.0
    held = episode.ticks[0] - episode.reset_tick
    rows = [one.tobytes().hex() for one in vectors]
    job: dict[str, Any] = {
        "env": "MobilePickPlace", "robot": "PandaOmron", "controller": None,
        "part_order": ["right", "right_gripper", "base", "torso"],
        "imports": ["fairlead_hal_sim.task"], "env_options": {}, "control_hz": 20.0,
        "episodes": [{"seed": SEED, "zeros": held, "vectors": rows}],
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, plain_robosuite.__file__],
        input=json.dumps(job),
        capture_output=True,
        text=True,
        check=True,
    )
    (plain,) = json.loads(done.stdout)["episodes"]
    ours = [
        episode.qpos[tick].tobytes().hex() for tick in range(episode.reset_tick, episode.ticks.stop)
    ]
    assert len(ours) == held + len(vectors) > 100
    assert plain["qpos"] == ours


def test_action_37_the_hand_comes_within_ten_centimetres_by_step_220(episode: Episode) -> None:
    """The hand comes within ten centimetres by step 220."""
    near = [
        tick
        for tick in episode.ticks
        if dict(episode.tasks[tick].metrics)["object_gripper_distance"] < NEAR_M
    ]
    assert near and near[0] - episode.ticks[0] <= NEAR_BY


def test_action_38_the_task_needs_the_base_and_the_base_drives(episode: Episode) -> None:
    """The base drives the object out of the arm's reach."""
    assert episode.result is not None
    assert (episode.result.outcome, episode.result.decided_by) == ("succeeded", "task")
    assert dict(episode.tasks[episode.ticks[-1]].metrics)["base_travel"] > 1.0
