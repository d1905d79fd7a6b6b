"""What the gate did not let pass, in words and with units, each said once."""

from __future__ import annotations

from fairlead.messages import Outcome, Verdict
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.wire.verdict_text import check_title
from fairlead_tools.teleop.drive import Drive

_RATE_OF_JOINT = 26
_METRES = (31, 32, 34)
_OF_ROWS = range(20, 26)


def refusal_text(robot: RobotManifest, drive: Drive, verdict: Verdict) -> str:
    """One line: check, place, number and limit with their unit."""
    where = f"{verdict.part} {verdict.axis}".strip()
    said = f"G{verdict.code:03d} {check_title(verdict.code)}" + (f": {where}" if where else "")
    if verdict.value == 0.0 and verdict.limit == 0.0:
        return f"{said}; needs {verdict.limit_source}" if verdict.limit_source else said
    unit = _unit(robot, drive, verdict)
    source = f" ({verdict.limit_source})" if verdict.limit_source else ""
    return f"{said}: {verdict.value:.4g}{unit}, limit {verdict.limit:.4g}{unit}{source}"


def _unit(robot: RobotManifest, drive: Drive, verdict: Verdict) -> str:
    """With a blank before it; "" where the number has none."""
    code, axis = verdict.code, verdict.axis
    if code in _METRES:
        return " m"
    if code not in (*_OF_ROWS, _RATE_OF_JOINT):
        return ""
    if axis in robot.measured_joint_names:
        return f" {robot.joint(axis).unit}" + ("/s" if code == _RATE_OF_JOINT else "")
    if axis == "opening":
        return f" {robot.joint(robot.part(verdict.part).joints[0]).unit}"
    rate = "/s" if drive.mode is ControlMode.BODY_TWIST else ""
    return f" {'rad' if axis == 'angular' else 'm'}{rate}"


class Refusals:
    """Which refusals are news: the same one, tick after tick, is said once."""

    def __init__(self, robot: RobotManifest, drive: Drive) -> None:
        self._robot, self._drive = robot, drive
        self._said = (0, "", "")
        self.newest = ""
        """The refusal that keeps the newest rows back; "" if they were released."""

    def news(self, verdict: Verdict) -> str:
        """What to tell the person of this verdict; "" if nothing, or nothing new."""
        if verdict.outcome == Outcome.RELEASED:
            self.newest = ""
            return ""
        self.newest = refusal_text(self._robot, self._drive, verdict)
        about = (verdict.code, verdict.part, verdict.axis)
        if about == self._said:
            return ""
        self._said = about
        return self.newest

    def forget(self) -> None:
        """The person asks for something new: what was said may be said again."""
        self._said = (0, "", "")
