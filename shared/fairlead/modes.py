"""Control modes: the closed set of things a part can be told to do.

The numbers are on the wire and in the C++ gate; they never change meaning.
"""

from __future__ import annotations

from enum import IntEnum


class ControlMode(IntEnum):
    """What the numbers of one action part mean. Values are SI and float64.

    Joint modes are as wide as the robot has commanded joints, with ``active`` naming
    the joints that count and 0.0 everywhere else.
    """

    JOINT_POSITION = 0  # rad or m
    JOINT_VELOCITY = 1  # rad/s or m/s
    JOINT_TORQUE = 2  # N m or N; no checker: nothing bounds where it leads; refused by name
    JOINT_TRAJECTORY = 3  # no checker yet: refused by name
    CARTESIAN_POSE = 4  # 7: xyz [m], quaternion xyzw, of the end effector in frame_id
    # 6: xyz [m], rotation vector r [rad] in one period, along frame_id's axes; R' = exp(r) R
    CARTESIAN_DELTA = 5
    # 6: xyz [m/s], rotation vector [rad/s], along frame_id's axes, beside what other parts do to it
    CARTESIAN_TWIST = 6
    BODY_TWIST = 7  # 6: xyz [m/s], xyz [rad/s], in base_link; 0 along axes the base cannot do
    FOOT_PLACEMENT = 8  # no checker yet: refused by name
    GRIPPER_BINARY = 9  # 1, as the next one: 0 open, 1 closed, nothing between
    GRIPPER_POSITION = 10  # total opening [m], or the angle of a joint that turns [rad]
    DEX_HAND_JOINT = 11  # rad or m
    COMPOSITE_MODE = 12  # 1: from -1 to 1, a simulator controller's own switch

    @property
    def yaml_name(self) -> str:
        """The name used in YAML and JSON files, for example ``cartesian_delta``."""
        return self.name.lower()

    @property
    def is_joint_mode(self) -> bool:
        """True where the width is the robot's number of commanded joints."""
        return self in _JOINT_MODES

    @property
    def is_tool_mode(self) -> bool:
        """True where the numbers say where an end effector goes."""
        return self in _TOOL_MODES

    @property
    def adds_up(self) -> bool:
        """True where a row is a way to go: a slower policy's is divided among control periods."""
        return self is ControlMode.CARTESIAN_DELTA

    @property
    def is_gripper_mode(self) -> bool:
        """True where the one number says how far a gripper is open, or whether it is."""
        return self in (ControlMode.GRIPPER_BINARY, ControlMode.GRIPPER_POSITION)

    def width(self, n_dof: int) -> int:
        """Numbers per row for a robot with ``n_dof`` commanded joints."""
        return n_dof if self.is_joint_mode else _FIXED_WIDTHS[self]


_TOOL_MODES = frozenset(
    {ControlMode.CARTESIAN_POSE, ControlMode.CARTESIAN_DELTA, ControlMode.CARTESIAN_TWIST}
)
_JOINT_MODES = frozenset(
    {
        ControlMode.JOINT_POSITION,
        ControlMode.JOINT_VELOCITY,
        ControlMode.JOINT_TORQUE,
        ControlMode.DEX_HAND_JOINT,
    }
)

_FIXED_WIDTHS = {
    ControlMode.CARTESIAN_POSE: 7,
    ControlMode.CARTESIAN_DELTA: 6,
    ControlMode.CARTESIAN_TWIST: 6,
    ControlMode.BODY_TWIST: 6,
    ControlMode.GRIPPER_BINARY: 1,
    ControlMode.GRIPPER_POSITION: 1,
    ControlMode.COMPOSITE_MODE: 1,
}

GATED_MODES = frozenset(
    {
        ControlMode.JOINT_POSITION,
        ControlMode.JOINT_VELOCITY,
        ControlMode.CARTESIAN_POSE,
        ControlMode.CARTESIAN_DELTA,
        ControlMode.CARTESIAN_TWIST,
        ControlMode.BODY_TWIST,
        ControlMode.GRIPPER_BINARY,
        ControlMode.GRIPPER_POSITION,
        ControlMode.DEX_HAND_JOINT,
        ControlMode.COMPOSITE_MODE,
    }
)
"""Modes the gate has a checker for in this release; every other mode is refused by name."""
