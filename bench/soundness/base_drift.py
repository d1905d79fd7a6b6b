"""How far a driving base leaves an arm from where the gate reckons with it.

    .venv/bin/python -m bench.soundness.base_drift [--episodes 200] [--first 0]

The mobile robot in its simulator, through the gate. The base drives to and fro at full scale, at
times with an arm at full scale before it; then the arm is told deltas of zero, or holds, for 1 to
12 ticks, and all rows end. Measured is from the state at which the last row was judged, for that is
where the gate looks last, until all rests: how far the tool gets from every place that the measured
motion leads to, by going on for a tick and braking, and how much nearer two capsules come than on
that way. Both over the base's share of full speed, as `tool_drift_m` and `clearance_drift_m` of
robot.yaml are meant. Episodes in which the robot touches anything do not count.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np

from bench.equipment.kinematics import Kinematics
from bench.soundness.arena import EXACT_M, Arena
from bench.soundness.attack import Parts
from bench.soundness.gate_loop import GateLoop
from fairlead.messages import FloatArray, Outcome
from fairlead.modes import ControlMode
from fairlead.robot.safety_profile import profile_limits
from fairlead_tools.measure.driven_robot import DrivenRobot, Moment, Tick

TOOL, REST_TICKS, LEAST_SHARE = "grip_site", 25, 0.2


@dataclass(frozen=True)
class Drift:
    """At full speed [m], and what led to it."""

    tool_m: float
    nearer_m: float
    share: float
    story: str


class BaseDrift:
    """One episode after the other."""

    def __init__(self) -> None:
        self.loop = GateLoop(DrivenRobot("panda_mobile"))
        self._robot = robot = self.loop.driven.robot
        self._arena = Arena(self.loop.file)
        self._kinematics = Kinematics(robot.description_path(), robot.measured_joint_names)
        limits = [profile_limits(joint, robot.profile("sim")) for joint in robot.joints]
        self._fastest = np.array([one[0] for one in limits[:3]])
        self._braking = np.array([one[1] for one in limits[3:10]])

    def episode(self, seed: int) -> Drift | None:
        """None where nothing can be said: it touched something, or the base hardly moved."""
        rng, loop = np.random.default_rng(seed), self.loop
        loop.begin(seed)
        modes = {"arm": ControlMode.CARTESIAN_DELTA, "base": ControlMode.JOINT_VELOCITY}
        parts = Parts(self._robot, {**modes, "composite": ControlMode.COMPOSITE_MODE})
        telling = ("zero", "held", "moving")[int(rng.integers(3))]
        switch = np.array([rng.choice([-1.0, 1.0])])
        way = rng.choice([-1.0, 0.0, 1.0], 3) * rng.choice([0.5, 1.0])
        half, arm = int(rng.integers(2, 9)), rng.choice([-1.0, 1.0], 6) * rng.uniform(0.1, 1.0)
        before, after = int(rng.integers(0, 9)), int(rng.integers(1, 13))
        done: list[Tick] = []
        for tick in range(before + after):
            wishes = {"base": way if tick // half % 2 else -way, "composite": switch}
            if tick < before or telling == "moving":
                wishes["arm"] = arm
            elif telling == "zero":
                wishes["arm"] = np.zeros(6)
            row = parts.row(wishes, loop.now)
            verdict = loop.propose([row])
            parts.go_on_after(row if verdict.outcome == Outcome.RELEASED else None)
            step = loop.advance("drift")
            if step is None or loop.stop_cause:
                return None
            done.append(step)
        last = done[-1]
        rest = [last, *(loop.hold("drift") for _ in range(REST_TICKS))]
        if not rest[-1].is_free or "base" not in last.commands:
            return None
        story = f"seed {seed}, arm {telling}, {before} ticks of it before and {after} ticks, {way}"
        return self._measured(last, rest, story)

    def _measured(self, last: Tick, rest: list[Tick], story: str) -> Drift | None:
        told = np.abs(last.commands["base"].values[:3])
        share = float(np.max(np.maximum(told, np.abs(last.before.velocities[:3])) / self._fastest))
        if share < LEAST_SHARE:
            return None
        way = self._way_of(last.before)
        places = np.stack([self._tool(q) for q in way])
        tool_m = max(
            float(np.linalg.norm(places - self._tool(t.after.positions), axis=1).min())
            for t in rest
        )
        on_way = self._arena.room_of_pairs(way).min(axis=1)
        came = self._arena.room_of_pairs(np.stack([t.after.positions for t in rest])).min(axis=1)
        nearer = np.where(came < EXACT_M, on_way - came, 0.0).max()
        return Drift(tool_m / share, float(nearer) / share, share, story)

    def _way_of(self, now: Moment) -> FloatArray:
        """Configurations ``[n, measured]`` that the arm's measured motion leads to."""
        speed = now.velocities[3:10]
        goes_on = speed * self._robot.tick_period_ns * 1e-9
        brakes = speed * np.abs(speed) / (2.0 * self._braking)
        way = np.repeat(now.positions[None, :], 21, axis=0)
        for i, share in enumerate(np.linspace(0.0, 2.0, 21)):
            way[i, 3:10] += min(share, 1.0) * goes_on + max(share - 1.0, 0.0) * brakes
        return way

    def _tool(self, q: FloatArray) -> FloatArray:
        return self._kinematics.pose(q, TOOL, self._robot.base_frame)[0]


def main() -> None:
    """Measure and print the largest."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.soundness.base_drift",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="seed (default: %(default)s)")
    arguments = parser.parse_args()
    drift, found = BaseDrift(), list[Drift]()
    try:
        for seed in range(arguments.first, arguments.first + arguments.episodes):
            one = drift.episode(seed)
            if one is None:
                continue
            if one.tool_m > max((old.tool_m for old in found), default=0.0):
                print(f"tool {one.tool_m:.4f} m at {one.share:.2f}: {one.story}", flush=True)
            if one.nearer_m > max((old.nearer_m for old in found), default=0.0):
                print(f"nearer {one.nearer_m:.4f} m at {one.share:.2f}: {one.story}", flush=True)
            found.append(one)
    finally:
        drift.loop.close()
    tools = sorted(one.tool_m for one in found)
    print(f"{len(found)} of {arguments.episodes} count; tool {tools[-1]:.4f} m, "
          f"99 % within {tools[int(0.99 * len(tools)) - 1]:.4f} m; "
          f"capsules nearer by {max(one.nearer_m for one in found):.4f} m")  # fmt: skip


if __name__ == "__main__":
    main()
