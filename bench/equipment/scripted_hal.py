"""A HAL that publishes what a test tells it to, in the robot's own order."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from bench.equipment.running_gate import ROBOT
from fairlead.keys import Keys
from fairlead.messages import (
    HELD,
    Acted,
    HalPart,
    HalStatus,
    JointState,
    pack_floats,
)
from fairlead.wire.bus import Bus, Qos

SESSION = 0x5E5510

REST = {"panda_joint4": -1.5, "panda_joint6": 1.5, "panda_gripper": 0.04}
"""Positions that differ from 0, within the limits."""


TREMOR = 1e-9
"""How far every position goes to and fro from tick to tick [rad or m]."""


class ScriptedHal:
    """Publishes hal/status and state/joints; `acted` is what its parts report to have done."""

    def __init__(
        self,
        bus: Bus,
        config: Path,
        *,
        session: int = SESSION,
        pacing: Literal["realtime", "lockstep"] = "lockstep",
        robot_hash: bytes | None = None,
        robot: str = ROBOT,
    ) -> None:
        keys = Keys(robot)
        self.robot = robot
        file = json.loads(config.read_text())
        self.robot_hash = robot_hash or bytes.fromhex(file["robot_hash"])
        self.period_ns = int(file["period_ns"])
        self.joints = [joint["name"] for joint in file["joints"]]
        self.passive = [joint["name"] for joint in file["passive_joints"]]
        self.parts = {part["name"]: part["joints"] for part in file["parts"]}
        self.session = session
        self.pacing: Literal["realtime", "lockstep"] = pacing
        self.tick = 0
        self.acted: list[Acted] = [HELD] * len(self.parts)
        self.positions = np.array([REST.get(name, 0.0) for name in (*self.joints, *self.passive)])
        self.velocities = np.zeros(len(self.positions))
        self.efforts = np.zeros(len(self.positions))
        self._states = bus.publisher(keys.joints, JointState, Qos.HOT)
        self._status = bus.publisher(keys.hal_status, HalStatus, Qos.STATUS)

    def publish_status(self) -> None:
        """Say who the robot is."""
        self._status.put(self.status())

    def status(self) -> HalStatus:
        """Who the robot is, as it says it."""
        parts = tuple(
            HalPart(name=name, simulator_part="", joints=tuple(joints), ranges=())
            for name, joints in self.parts.items()
        )
        return HalStatus(
            session=self.session,
            robot=self.robot,
            robot_hash=self.robot_hash,
            pacing=self.pacing,
            period_ns=self.period_ns,
            tick=self.tick,
            episode_tick=1,
            state="ready",
            detail="",
            joints=tuple(self.joints),
            passive_joints=tuple(self.passive),
            parts=parts,
            simulator_order=(),
            cameras=(),
            has_task=False,
            overruns=0,
        )

    def publish_state(self, acted: Sequence[Acted] | None = None) -> int:
        """The next tick, standing still unless `velocities` say otherwise; returns it.

        Sensors tremble: a joint that is told to move and never changes would be a stuck one.
        """
        self.tick += 1
        self.positions += TREMOR if self.tick % 2 else -TREMOR
        if acted is not None:
            self.acted = list(acted)
        self.repeat_state()
        return self.tick

    def repeat_state(self) -> None:
        """The newest tick again, as a paused HAL does."""
        self._states.put(
            JointState(
                session=self.session,
                tick=self.tick,
                episode_tick=1,
                stamp_ns=0,
                positions=pack_floats(self.positions),
                velocities=pack_floats(self.velocities),
                efforts=pack_floats(self.efforts),
                acted=tuple(self.acted),
                robot_hash=self.robot_hash,
            )
        )

    def held(self) -> list[Acted]:
        """Every part held."""
        return [Acted(hold=1, verdict_id=0, row=0)] * len(self.parts)

    def executed(self, verdict_id: int, row: int, parts: Sequence[str]) -> list[Acted]:
        """``parts`` executed a row, the others held."""
        done = Acted(hold=0, verdict_id=verdict_id, row=row)
        return [done if name in parts else self.held()[0] for name in self.parts]
