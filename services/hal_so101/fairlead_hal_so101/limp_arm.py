"""An arm that a person moves by hand, and that is only read: the leader of another."""

from __future__ import annotations

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_so101.calibration import calibration_path, load_calibration
from fairlead_hal_so101.servo_bus import LostAnswerError, calibrated_bus
from fairlead_hal_so101.servo_reading import ServoFault, ServoReading

ANSWER_TIMEOUT_S = 0.05
"""For one servo: nothing else waits for a leader."""
_SLACK_STEPS = 150
"""How far outside its calibrated range a joint may be found: 13 degrees."""
_WHO = "leader arm"


class LimpArm:
    """A leader on a serial port: its torque is off, and nothing is ever written to it.

    Args:
        robot: whose joints the arm has; where that has its jaw, the arm has a trigger.
        calibration: a name or a path, of a calibration made with ``--arm leader``.

    Attributes:
        joints: by name, in the order of what is read.
        trigger: its place among them.

    Raises:
        ConfigError: what is on the port is not that arm, or it is not limp.
        HardwareError: it does not answer.
    """

    def __init__(self, robot: RobotManifest, port: str, calibration: str) -> None:
        found = load_calibration(calibration, robot, "leader")
        self._servos = found.servos
        self.joints = tuple(servo.joint for servo in self._servos)
        self.trigger = self.joints.index(str(robot.end_effectors[0].gripper_joint))
        file = calibration_path(calibration)
        self._bus = calibrated_bus(port, found, file, ANSWER_TIMEOUT_S, _WHO)
        stiff = [one for one in found.ids if self._bus.get(one, "torque_enable")]
        if stiff:
            self._bus.close()
            got = f"torque in servo {self._bus.named(stiff)}; is {port} the follower?"
            what = "a limp arm (switch its power off and on)"
            raise ConfigError(expected(_WHO, what, got))

    def read(self) -> FloatArray:
        """Where its joints are [rad]; of its trigger the share of the way it has, from 0 to 1.

        Raises:
            LostAnswerError: this measurement is lost, or cannot be right; it says why.
            HardwareError: the port is gone.
        """
        readings = self._bus.read()
        for one, reading in zip(self._servos, readings, strict=True):
            if wrong := disbelieved(reading, one.lower_steps, one.upper_steps):
                raise LostAnswerError(f"servo {self._bus.named([one.id])}: {wrong}")
        steps = [reading.position_steps for reading in readings]
        found = [one.rad(each) for one, each in zip(self._servos, steps, strict=True)]
        found[self.trigger] = self._servos[self.trigger].share(steps[self.trigger])
        return np.array(found)

    def why_lost(self, reason: str) -> str:
        """Which servos are silent now; ``reason``, if none is. It asks each, and takes a moment."""
        return self._bus.why_lost(reason)

    def close(self) -> None:
        """Let go of the port."""
        self._bus.close()


def disbelieved(reading: ServoReading, lower_steps: int, upper_steps: int) -> str:
    """Why a reading is not believed; "" if it is."""
    if reading.has_torque:
        return "has torque: it is not limp any more"
    if reading.faults & ServoFault.SENSOR:
        return "says that its encoder is broken"
    if not lower_steps - _SLACK_STEPS <= reading.position_steps <= upper_steps + _SLACK_STEPS:
        return f"reads {reading.position_steps}, calibrated {lower_steps} to {upper_steps} steps"
    return ""
