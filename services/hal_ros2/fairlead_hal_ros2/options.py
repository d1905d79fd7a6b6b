"""Options of ``run: hal_ros2`` in a deployment file."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, model_validator

from fairlead.ros2.link import Ros2Link, Topic

Seconds = Annotated[float, Field(gt=0, le=60, allow_inf_nan=False)]
Factor = Annotated[float, Field(allow_inf_nan=False)]


class PartTopic(BaseModel):
    """Where a part's joint positions go: exactly one of these.

    trajectory: a `trajectory_msgs/JointTrajectory` of one point, a period away.
    positions: a `std_msgs/Float64MultiArray`, in the order of the part's joints.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    trajectory: Topic | None = None
    positions: Topic | None = None

    @model_validator(mode="after")
    def _one_of_them(self) -> PartTopic:
        if (self.trajectory is None) == (self.positions is None):
            got = "neither" if self.trajectory is None else "both"
            raise ValueError(f"expected trajectory or positions, got {got}")
        return self


class BaseTopics(BaseModel):
    """A mobile base.

    odometry: a `nav_msgs/Odometry`; its pose is ``odom -> base_link``.
    twist: a `geometry_msgs/Twist`, along the axes of ``base_link``.
    child_frame: the frame that the odometry says it is about.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    odometry: Topic = "/odom"
    twist: Topic = "/cmd_vel"
    child_frame: str = "base_link"


class Ros2Options(Ros2Link):
    """Which topics the robot has, besides where it is (`Ros2Link`).

    joint_states: its `sensor_msgs/JointState`.
    joints: what a joint of robot.yaml is there, where not a joint of its name: the sum of these,
        each times its factor.
    parts: where the commands of each part go that has joints and is not the base.
    base: topics of the base; None: the robot stands still in ``odom``.
    tf: its `tf2_msgs/TFMessage`.
    frames: frames to take from there, each with the parent that it has there.
    without_effort: joints whose effort nobody measures: it is 0, and the gate feels no contact.
    stale_after_s: a state that is older stops the robot.
    start_timeout_s: how long the first state and the listeners are waited for.
    """

    joint_states: Topic = "/joint_states"
    joints: dict[str, Annotated[dict[str, Factor], Field(min_length=1)]] = Field(
        default_factory=dict
    )
    parts: dict[str, PartTopic] = Field(default_factory=dict)
    base: BaseTopics | None = None
    tf: Topic = "/tf"
    frames: dict[str, str] = Field(default_factory=dict)
    without_effort: tuple[str, ...] = ()
    stale_after_s: Seconds = 0.2
    start_timeout_s: Seconds = 10.0
