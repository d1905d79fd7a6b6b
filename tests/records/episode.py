"""One whole episode of the expert through the real processes, and all that was said in it."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bench.equipment.live_robot import SKILL, LiveRobot
from fairlead.deploy.registry import Registry
from fairlead.messages import (
    ActionChunk,
    FloatArray,
    GoalResult,
    JointState,
    LayoutState,
    TaskState,
    TransformBatch,
    decode,
    floats,
)
from fairlead.paths import repo_root
from fairlead.wire.bus import Sample
from fairlead_skill_runner.trace import TraceRecord, read_trace
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot

SEED = 101
"""One that no other test uses."""

STALL_S = 60.0
"""A slow machine is no failure."""

TRACED = {"hal": {"trace": True}, "runner": {"trace": True}}


@dataclass
class Episode:
    """What was heard on the bus, and what policy and simulator wrote down.

    packed, qpos: what `env.step` was given, float32 ``[12]``, and the state before it, by tick.
    joints: measured positions by tick, float64 ``[14]``.
    reset_tick: the first one after the reset.
    """

    chunks: list[ActionChunk] = field(default_factory=list)
    layouts: dict[int, LayoutState] = field(default_factory=dict)
    transforms: dict[str, dict[int, TransformBatch]] = field(default_factory=dict)
    tasks: dict[int, TaskState] = field(default_factory=dict)
    calls: list[TraceRecord] = field(default_factory=list)
    packed: dict[int, FloatArray] = field(default_factory=dict)
    qpos: dict[int, FloatArray] = field(default_factory=dict)
    joints: dict[int, FloatArray] = field(default_factory=dict)
    reset_tick: int = 0
    result: GoalResult | None = None

    @property
    def ticks(self) -> range:
        """Every tick in which the goal was there."""
        assert self.result is not None
        return range(self.result.first_tick, self.result.last_tick)

    def on_transforms(self, sample: Sample) -> None:
        """Keep a batch by its publisher; static ones apart."""
        batch = decode(TransformBatch, sample.payload)
        name = sample.key.rsplit("/", 1)[-1] + ("/static" if batch.is_static else "")
        self.transforms.setdefault(name, {})[batch.tick] = batch

    def on_layout(self, sample: Sample) -> None:
        """Keep the expert's state vectors."""
        state = decode(LayoutState, sample.payload)
        self.layouts[state.tick] = state

    def on_joints(self, sample: Sample) -> None:
        """Keep what was measured."""
        state = decode(JointState, sample.payload)
        self.joints[state.tick] = floats(state.positions)

    def on_task(self, sample: Sample) -> None:
        """Keep the task's own measurements."""
        task = decode(TaskState, sample.payload)
        self.tasks[task.tick] = task

    def read_traces(self, state_dir: Path) -> None:
        """Add what runner and HAL wrote down."""
        self.calls = list(read_trace(state_dir / "runner" / "trace.jsonl"))
        for line in (state_dir / "hal" / "trace.jsonl").read_text().splitlines():
            step = json.loads(line)
            self.packed[step["tick"]] = np.frombuffer(bytes.fromhex(step["packed"]), "<f4")
            self.qpos[step["tick"]] = np.frombuffer(bytes.fromhex(step["qpos"]), "<f8")


def record_episode(folder: Path) -> Episode:
    """Run the task once, in lockstep, in the simulator."""
    source = repo_root() / "compose" / "panda_mobile_sim.yaml"
    scratch = make_scratch(
        source, folder / "state", ScratchOptions(pacing="lockstep", options=TRACED)
    )
    episode = Episode()
    with scratch_robot(scratch, Registry(folder / "registry")) as running:
        robot = LiveRobot(running)
        bus, keys = robot.client.bus, robot.client.keys
        bus.subscribe(keys.every_tf, episode.on_transforms)
        bus.subscribe(keys.layout(SKILL), episode.on_layout)
        bus.subscribe(keys.task, episode.on_task)
        bus.subscribe(keys.joints, episode.on_joints)
        bus.subscribe(
            keys.every_candidate, lambda s: episode.chunks.append(decode(ActionChunk, s.payload))
        )
        reset = robot.ready_to_move(SEED)
        episode.reset_tick = reset.tick - reset.held_ticks
        episode.result = robot.start_goal(stall_timeout_s=STALL_S).result(timeout=240.0).result
    assert episode.result is not None
    assert episode.result.outcome == "succeeded", (episode.result, scratch.state_dir)
    episode.read_traces(scratch.state_dir)
    return episode
