"""What the pose of a leader arm asks of the arm that follows it: the decision, without the arm."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from fairlead.messages import FloatArray
from fairlead_tools.teleop.device import Deflection
from fairlead_tools.teleop.drive import Drive

SILENCE_S = 0.3
"""So long without a pose, and the follower holds until the clutch is let in again."""
ALIGNED_RAD = 0.05
"""So near to the leader in every joint, and it is followed as fast as it moves."""
AWAY_RAD = 0.35
"""So far behind it in a joint, and the way to it is gone at the speed that was set, once more."""
GAIN = 0.5
"""Of what is left, the most that is asked for in one row."""
BRAKES = 0.8
"""Of the drive's change a row, with which a way ends: with all of it, it would overshoot."""
FASTEST_RAD_S, SLACK_RAD = 15.0, 0.1
"""No hand moves an arm faster; slack for what two readings are off."""
TRIGGER_MOVED = 0.05
"""So much of its way a trigger has to move before the gripper is told anything."""


@dataclass(frozen=True)
class Pose:
    """Where a leader was.

    joints: of the drive, in its order, ``[n]`` [rad]. trigger: share of its way, 1 is open.
    at_s: monotonic time before it was asked for.
    """

    joints: FloatArray
    trigger: float
    at_s: float


class Following:
    """The follower's joints go to where the leader's are, the gripper to where the trigger is.

    When the clutch is let in, the way there is gone at the speed that was set; from then on the
    leader is followed as fast as it moves, up to full speed.

    Attributes:
        lets_go: the clutch has to be let out, and in again by the person.
    """

    def __init__(self, drive: Drive) -> None:
        self._drive = drive
        self._pose: Pose | None = None
        self._trouble = "says nothing yet"
        self._is_aligned = False
        self._trigger_0: float | None = None
        self._trigger_moved = False
        self._lost = ""
        self.lets_go = False

    def hears(self, pose: Pose) -> None:
        """A pose that was read; one that no hand can have brought about is not believed."""
        before, self._trouble = self._pose, ""
        self._pose = pose
        if before is None:
            return
        most = FASTEST_RAD_S * (pose.at_s - before.at_s) + SLACK_RAD
        way = np.abs(pose.joints - before.joints)
        if (way > most).any():
            name = self._drive.names[int(np.argmax(way))]
            self._lose(f"{name} leapt by {np.max(way):.2f} rad")

    def misses(self, why: str) -> None:
        """A pose could not be read."""
        self._trouble = why

    def read(self, asked: Deflection, now_s: float, at: FloatArray) -> Deflection:
        """What is asked for now.

        Args:
            asked: clutch, speed and wish.
            at: where the follower's targets have come to, ``[n]`` [rad]; empty: it is not driven.
        """
        age_s = math.inf if self._pose is None else now_s - self._pose.at_s
        if age_s > SILENCE_S:
            self._lose(self._trouble or f"silent for {SILENCE_S} s")
        self.lets_go = asked.clutch and bool(self._lost)
        if self._pose is None or self._lost or not asked.clutch or not at.size:
            self._is_aligned, self._trigger_0, self._trigger_moved = False, None, False
            note = f"leader: {self._lost}; holding, let the clutch in again" if self._lost else ""
            if self._lost and age_s <= SILENCE_S and not asked.clutch:
                self._lost = ""
            return dataclasses.replace(asked, axes=(0.0,) * at.size, age_s=age_s, note=note)
        return self._follow(asked, self._pose, at, age_s)

    def _follow(self, asked: Deflection, pose: Pose, at: FloatArray, age_s: float) -> Deflection:
        drive = self._drive
        left = np.clip(pose.joints, drive.lower, drive.upper) - at
        far = float(np.max(np.abs(left)))
        self._is_aligned = far <= (AWAY_RAD if self._is_aligned else ALIGNED_RAD)
        speed = 1.0 if self._is_aligned else asked.speed
        slows = BRAKES * drive.change
        fastest = slows * (np.sqrt(0.25 + 2.0 * np.abs(left) / slows) - 0.5)
        steps = np.copysign(np.minimum(GAIN * np.abs(left), fastest), left)
        share = np.clip(steps / (drive.full * speed), -1.0, 1.0)
        if self._trigger_0 is None:
            self._trigger_0 = pose.trigger
        moved = abs(pose.trigger - self._trigger_0) > TRIGGER_MOVED
        self._trigger_moved = self._trigger_moved or moved
        return dataclasses.replace(
            asked,
            axes=tuple(share.tolist()),
            speed=speed,
            age_s=age_s,
            opening=pose.trigger if self._trigger_moved else None,
            note="follows the leader" if self._is_aligned else "aligning with the leader",
        )

    def _lose(self, why: str) -> None:
        self._lost = why
