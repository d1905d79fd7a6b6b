"""How far and how fast a new skill waves a joint: within half of what its limits let it."""

from __future__ import annotations

import math

from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part
from fairlead.robot.safety_profile import profile_limits

PERIODS = 40
"""Of a wave, there and back."""
STRENGTH = 0.9
"""Of a wave of speeds, in the slot's scale."""
_TURN = 2.0 * math.pi / PERIODS
_SHARE, _NEAR = 0.5, 0.05
_FAR, _FAST = {"rad": 0.2, "m": 0.1}, {"rad": 0.5, "m": 0.2}


def waving_joint(robot: RobotManifest, part: Part) -> str:
    """The joint before the last; another where that one's home is an end stop."""
    names = [*part.joints[-2::-1], part.joints[-1]]
    return next((one for one in names if not _rests_at_end(robot, robot.joint(one))), names[0])


def wave_height(robot: RobotManifest, part: Part, name: str) -> float:
    """How far joint targets go from home [rad or m], to the side with more room."""
    joint, room = robot.joint(name), _room(robot, robot.joint(name))
    speed, acceleration = _limits(robot, joint)
    modes = (profile.parts[part.name].joint_position for profile in robot.safety.values())
    step = min(mode.step_limits[part.joints.index(name)] for mode in modes if mode)
    period_s = robot.tick_period_ns * 1e-9
    step = min(step, speed * period_s)
    most = min(2.0 * step / _TURN, 2.0 * acceleration * (period_s / _TURN) ** 2, abs(room))
    return math.copysign(floor(min(_FAR[joint.unit], _SHARE * most)), room)


def wave_speed(robot: RobotManifest, part: Part, name: str) -> float:
    """Full scale of a joint's speed [rad/s or m/s]."""
    joint = robot.joint(name)
    speed, acceleration = _limits(robot, joint)
    modes = (profile.parts[part.name].joint_velocity for profile in robot.safety.values())
    step = min(mode.step_limits[part.joints.index(name)] for mode in modes if mode)
    period_s = robot.tick_period_ns * 1e-9
    step = min(step, acceleration * period_s)
    height = 0.5 * abs(_room(robot, joint)) * _TURN / period_s  # a half wave goes 2 / _TURN rows
    most = min(speed, step / _TURN, height)
    return floor(min(_FAST[joint.unit], _SHARE * most))


def wave_side(robot: RobotManifest, name: str) -> float:
    """1 or -1: where a joint has more room."""
    return math.copysign(1.0, _room(robot, robot.joint(name)))


def floor(value: float) -> float:
    """Rounded down to two digits: a number to read and to change."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.floor(value / unit) * unit:.2g}")


def _limits(robot: RobotManifest, joint: Joint) -> tuple[float, float]:
    """Speed and acceleration that every profile allows."""
    found = [profile_limits(joint, safety) for safety in robot.safety.values()]
    return min(one[0] for one in found), min(one[1] for one in found)


def _room(robot: RobotManifest, joint: Joint) -> float:
    """From home to the end that is farther, with its sign [rad or m]."""
    return max(_ways(robot, joint), key=abs)


def _rests_at_end(robot: RobotManifest, joint: Joint) -> bool:
    """Whether a wave that comes home reaches an end stop, where its last row still moves (G024)."""
    nearest = min(map(abs, _ways(robot, joint)))
    return joint.has_bounds and nearest < _NEAR * abs(_room(robot, joint))


def _ways(robot: RobotManifest, joint: Joint) -> tuple[float, float]:
    """From home to the upper and the lower end [rad or m]."""
    if not joint.has_bounds:
        return math.inf, -math.inf
    middle = 0.5 * (joint.lower + joint.upper)
    home = middle if robot.home is None else robot.home.positions.get(joint.name, middle)
    return joint.upper - home, joint.lower - home
