"""The loop of one claim: tick by tick, what the device asks for becomes rows for the gate."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fairlead.errors import ChunkRefusedError
from fairlead.messages import ActionPart, FloatArray, Hold, Outcome, Verdict, floats
from fairlead.modes import ControlMode
from fairlead.operate.blocking import BlockingClaim
from fairlead.operate.tick import Tick
from fairlead.robot.free_axes import FreeAxes
from fairlead.robot.manifest import RobotManifest
from fairlead.wire.verdict_text import finding_text
from fairlead_tools.teleop.device import Deflection, InputDevice, Wish
from fairlead_tools.teleop.drive import Drive
from fairlead_tools.teleop.grip import Grip
from fairlead_tools.teleop.pilot import Pilot

At = Callable[[Tick], FloatArray]
"""Where the axes of a drive that is told speeds are at a tick: how far from the start."""


@dataclass(frozen=True)
class State:
    """What a person is shown after each tick.

    at: where the axes are: joints as measured, other axes as `At` says [rad or m].
    news: a refusal that was not told yet, else "". held_back: the newest one while it lasts.
    """

    tick: int
    at: FloatArray
    asked: Deflection
    is_moving: bool
    news: str
    held_back: str


class HandDriving:
    """One drive, one device, one claim.

    Args:
        robot: whose manifest.
        lockstep: whether the world waits for a row; it is then kept from running faster than
            the robot would, and gets one row at a time: it would not wait for a newer one.
        horizon: rows of a chunk, at most.
        at: where the axes are; None: told to nobody.
        paced: False: a lockstep world may run as fast as it can.
    """

    def __init__(
        self,
        robot: RobotManifest,
        drive: Drive,
        grip: Grip | None,
        device: InputDevice,
        *,
        lockstep: bool,
        horizon: int,
        at: At | None = None,
        paced: bool = True,
    ) -> None:
        self._robot, self._drive, self._grip, self._device = robot, drive, grip, device
        ahead, most = (0, 1) if lockstep else (1, horizon)
        self._pilot = Pilot(drive, ahead=ahead, horizon=most, silence_s=device.silence_s)
        self._refusals = Refusals()
        self._at = at
        self._period_s = robot.tick_period_ns * 1e-9 if lockstep and paced else 0.0
        self._part = robot.part_names.index(drive.part)
        self._free: FreeAxes | None = None
        if drive.tool and len(drive.columns) < drive.width:
            self._free = FreeAxes(robot, robot.part(drive.part), drive.frame, drive.columns)

    def run(self, claim: BlockingClaim, show: Callable[[State], None]) -> Wish:
        """Drive until the device wishes otherwise, and the robot has come to rest.

        Raises:
            ClaimLostError: the gate took the claim back.
            ServiceError: the device is gone.
        """
        due_s = time.monotonic()
        wish: Wish = ""
        while True:
            tick = claim.next_tick()
            measured = self._measured(tick)
            now_s = time.monotonic()
            at = self._at(tick) if self._at is not None else measured
            asked = self._device.read(now_s, self._pilot.commanded(tick.number, at))
            wish = wish or asked.wish
            if wish:  # to rest first
                asked = Deflection(axes=(0.0,) * len(self._drive.names))
            news = self._refusals.news(self._send(claim, tick, measured, asked))
            if not any(asked.axes):
                self._refusals.forget()
            is_moving = not self._pilot.at_rest and not self._refusals.newest
            show(State(tick.number, at, asked, is_moving, news, self._refusals.newest))
            if wish and self._pilot.at_rest:
                return wish
            due_s = max(due_s + self._period_s, now_s)
            time.sleep(max(0.0, due_s - time.monotonic()))

    def _measured(self, tick: Tick) -> FloatArray:
        if not self._drive.is_position:
            return np.zeros(len(self._drive.names))
        own = [self._robot.joint_names.index(name) for name in self._drive.names]
        return floats(tick.joints.positions)[own]

    def _send(
        self, claim: BlockingClaim, tick: Tick, measured: FloatArray, asked: Deflection
    ) -> Verdict:
        is_held = tick.joints.acted[self._part].hold != Hold.NONE
        rows = self._pilot.rows(tick.number, measured, is_held, asked)
        parts = [self._rows(claim, rows, tick), *self._grip_rows(claim, tick, asked, len(rows))]
        try:
            verdict = claim.send(tick.number, *parts)
        except ChunkRefusedError as error:
            verdict = error.verdict
        self._pilot.judged(verdict.released_last)
        return verdict

    def _rows(self, claim: BlockingClaim, rows: FloatArray, tick: Tick) -> ActionPart:
        drive = self._drive
        if drive.is_position:
            return claim.rows(drive.part, drive.mode, rows, joints=drive.names)
        wide = np.zeros((len(rows), drive.width))
        wide[:, list(drive.columns)] = rows
        if self._free is not None:
            wide = self._free.completed(wide, floats(tick.joints.positions))
        frame = drive.frame if drive.mode is ControlMode.CARTESIAN_DELTA else ""
        return claim.rows(drive.part, drive.mode, wide, frame=frame)

    def _grip_rows(
        self, claim: BlockingClaim, tick: Tick, asked: Deflection, count: int
    ) -> list[ActionPart]:
        grip = self._grip
        if grip is None:
            return []
        index = self._robot.joint_names.index(grip.joint)
        target = grip.target(float(floats(tick.joints.positions)[index]), asked)
        return [] if target is None else [claim.rows(grip.part, grip.mode, [[target]] * count)]


class Refusals:
    """Which refusals are news: the same one, tick after tick, is said once."""

    def __init__(self) -> None:
        self._said = (0, "", "")
        self.newest = ""
        """The refusal that keeps the newest rows back; "" if they were released."""

    def news(self, verdict: Verdict) -> str:
        """What to tell the person of this verdict; "" if nothing, or nothing new."""
        if verdict.outcome == Outcome.RELEASED:
            self.newest = ""
            return ""
        self.newest = finding_text(verdict)
        about = (verdict.code, verdict.part, verdict.axis)
        if about == self._said:
            return ""
        self._said = about
        return self.newest

    def forget(self) -> None:
        """The person asks for something new: what was said may be said again."""
        self._said = (0, "", "")
