"""An SO-101 leader arm as an input device: its joints lead, the space bar is the clutch."""

from __future__ import annotations

import threading
import time

from fairlead.errors import ConfigError, HardwareError, ServiceError, expected
from fairlead.messages import FloatArray
from fairlead.paths import robot_ids
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_hal_so101 import LimpArm, LostAnswerError
from fairlead_tools.teleop.device import Deflection
from fairlead_tools.teleop.drive import Drive
from fairlead_tools.teleop.follow import SILENCE_S, Following, Pose
from fairlead_tools.teleop.keyboard import Keyboard, Keys

EVERY_S = 0.01
"""A pause between two readings, each of about 3 ms."""
MODEL = "so101"
"""The robot whose joints a leader has."""


class LeaderArm:
    """A leader that is read by a thread of its own, so that a silent bus delays nobody.

    Args:
        arm: open; closed when the block ends.
        keyboard: has the clutch, the speed and the wishes.
    """

    silence_s = SILENCE_S

    def __init__(self, arm: LimpArm, keyboard: Keyboard, drive: Drive) -> None:
        self._arm, self._keyboard = arm, keyboard
        self._own = [arm.joints.index(name) for name in drive.names]
        self._following = Following(drive)
        self._lock = threading.Lock()
        self._heard, self._ended = threading.Event(), threading.Event()
        self._gone = ""
        self._thread = threading.Thread(target=self._listen, name="leader", daemon=True)

    def __enter__(self) -> LeaderArm:
        self._keyboard.__enter__()
        self._thread.start()
        self._heard.wait(SILENCE_S)
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
        self._arm.close()
        self._keyboard.__exit__()

    @property
    def help(self) -> str:
        """How it is used."""
        return f"move the leader arm; {self._keyboard.help}"

    def read(self, now_s: float, at: FloatArray) -> Deflection:
        """As `InputDevice.read`.

        Raises:
            ServiceError: its adapter was unplugged, or the terminal is gone.
        """
        if self._gone:
            raise ServiceError(f"{self._gone}; the robot holds")
        asked = self._keyboard.read(now_s, at)
        with self._lock:
            found = self._following.read(asked, now_s, at)
            if self._following.lets_go:
                self._keyboard.let_out()
        return found

    def _listen(self) -> None:
        """Until the end, or until the port is gone."""
        heard_s = time.monotonic()
        try:
            while not self._ended.wait(EVERY_S):
                asked_s = time.monotonic()
                try:
                    found = self._arm.read()
                except LostAnswerError as error:
                    why = str(error)
                    if asked_s - heard_s > SILENCE_S:
                        why = self._arm.why_lost(why)
                    with self._lock:
                        self._following.misses(why)
                    continue
                heard_s = asked_s
                with self._lock:
                    self._following.hears(
                        Pose(found[self._own], float(found[self._arm.trigger]), asked_s)
                    )
                self._heard.set()
        except HardwareError as error:
            self._gone = str(error)


def open_leader(
    robot: RobotManifest, drive: Drive, port: str, calibration: str, speed: float
) -> LeaderArm:
    """The leader on a port, for a drive that has its joints.

    Raises:
        ConfigError: the drive has other joints, or what is on the port is no leader that is limp.
        HardwareError: it does not answer.
    """
    model = load_robot(MODEL)
    trigger = {tool.gripper_joint for tool in model.end_effectors}
    joints = [name for name in model.joint_names if name not in trigger]
    if set(drive.names) != set(joints):
        fits = [one for one in robot_ids() if set(joints) <= set(load_robot(one).joint_names)]
        what = f"a part whose joints a leader arm has ({', '.join(joints)}), told joint_position"
        got = f"{drive.part} of {robot.id} in {drive.mode.yaml_name}"
        raise ConfigError(
            expected("teleop: --device so101", f"{what}, as of the robots listed", got, fits)
        )
    if not port:
        raise ConfigError("teleop: --device so101 needs the leader's --port, as /dev/ttyACM1")
    keyboard = Keyboard(Keys((), speed))
    return LeaderArm(LimpArm(model, port, calibration), keyboard, drive)
