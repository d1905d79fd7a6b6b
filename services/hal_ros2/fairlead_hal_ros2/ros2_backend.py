"""Ros2Backend: a robot whose drivers are in a ROS 2 system, behind the HAL contract."""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping, Sequence

import numpy as np

from fairlead.errors import ConfigError, FairleadError, ServiceError, expected
from fairlead.hal.backend import (
    BackendDescription,
    FramePose,
    Measurement,
    PartCommand,
    describe_part,
)
from fairlead.hal.setpoints import Setpoints
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part
from fairlead.ros2.messages import JOINT_STATE, ODOMETRY, TF_MESSAGE, TWIST
from fairlead.ros2.node import RosNode
from fairlead_hal_ros2.frames import Frames
from fairlead_hal_ros2.joint_states import JointSource, JointStates, age_s, measurement
from fairlead_hal_ros2.mobile_base import BaseDrive, Odometry, twist_message
from fairlead_hal_ros2.options import Ros2Options
from fairlead_hal_ros2.part_drive import PartDrive
from fairlead_hal_ros2.robot_fit import check_fit, yaw_axis

HERE, UPRIGHT = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
POLL_S = 0.02
REST_PERIODS = 20
"""Periods in which a part at rest is still told so: a message may be lost. Then it is told nothing,
so that whoever else moves the robot is not pulled back; the next row goes on from there."""
_LOG = logging.getLogger("hal_ros2")


class Ros2Backend:
    """Implements `fairlead.hal.backend.Backend`.

    Args:
        robot: its manifest; the topics must have its joints.
        profile: safety profile whose limits are told as command ranges.

    Raises:
        ConfigError: options that do not fit the robot.
        ServiceError: a state or a listener did not come in time, and which.
        TransportError: the router cannot be reached.
    """

    def __init__(self, robot: RobotManifest, profile: str, options: Ros2Options) -> None:
        check_fit(robot, profile, options)
        self._robot, self._profile, self._options = robot, profile, options
        self._base = set(robot.base_joints) if options.base else set()
        self._sources = [
            None if name in self._base else self._source(name)
            for name in robot.measured_joint_names
        ]
        self._turning = [
            index
            for index, joint in enumerate(robot.joints)
            if joint.type == "continuous" and joint.name not in self._base
        ]
        self._turns = np.full(len(self._turning), np.nan)  # as measured in the tick before
        self._states = JointStates()
        self._frames = Frames(options.frames, options.stale_after_s)
        self._odometry = None
        if options.base:
            self._yaw_axis = yaw_axis(robot, profile)
            self._odometry = Odometry(options.base, robot.base_frame, self._yaw_axis)
        self._node = RosNode(options, "fairlead_hal")
        try:
            self._connect()
            self._wait()
        except FairleadError:
            self._node.close()
            raise
        self._setpoints.restart(self.read().positions[: robot.n_dof])

    def _source(self, joint: str) -> JointSource:
        factors = self._options.joints.get(joint, {joint: 1.0})
        return JointSource(joint, factors, joint not in self._options.without_effort)

    def _connect(self) -> None:
        robot, options, node = self._robot, self._options, self._node
        parts = [part for part in robot.parts if part.name in options.parts]
        self._setpoints = Setpoints(robot, parts=parts, who="hal_ros2", profile=self._profile)
        self._drives = {part.name: self._drive(part) for part in parts}
        self._at_rest = dict.fromkeys((*self._drives, "base"), REST_PERIODS)
        self._listeners = [(drive.topic, drive.kind) for drive in self._drives.values()]
        if options.base is not None and self._odometry is not None:
            odometry = self._odometry
            self._base_drive = BaseDrive(robot, self._profile, self._yaw_axis)
            self._twists = node.publisher(options.base.twist, TWIST)
            self._listeners.append((options.base.twist, TWIST))
            node.subscribe(
                options.base.odometry, ODOMETRY, lambda m: odometry.take(m, time.monotonic())
            )
        if options.frames:
            node.subscribe(options.tf, TF_MESSAGE, lambda m: self._frames.take(m, time.monotonic()))
        node.subscribe(
            options.joint_states, JOINT_STATE, lambda m: self._states.take(m, time.monotonic())
        )

    def _drive(self, part: Part) -> PartDrive:
        joints = [self._robot.joint_names.index(name) for name in part.joints]
        sources = [self._source(name) for name in part.joints]
        topic, period_ns = self._options.parts[part.name], self._robot.tick_period_ns
        return PartDrive(self._node, topic, joints, sources, period_ns)

    def _wait(self) -> None:
        """Until all that is needed is there."""
        timeout_s, said = self._options.start_timeout_s, ""
        deadline_s = time.monotonic() + timeout_s
        while problem := self._problem():
            if problem != said:
                said = problem
                _LOG.info("waits: %s", problem)
            if time.monotonic() > deadline_s:
                raise ServiceError(f"hal_ros2: not ready after {timeout_s:g} s: {problem}")
            time.sleep(POLL_S)

    def _problem(self) -> str:
        """What is missing or too old; "" if nothing is."""
        options, now_s = self._options, time.monotonic()
        readings = self._states.newest()
        sources = [source for source in self._sources if source is not None]
        for source in sources:
            if text := source.problem(readings):
                return self._silent(options.joint_states, JOINT_STATE, text)
        ages = [(options.joint_states, age_s(sources, readings, now_s) if sources else 0.0)]
        if options.base is not None and self._odometry is not None:
            newest = self._odometry.newest
            if newest is None:
                return self._silent(options.base.odometry, ODOMETRY, "nothing came")
            ages.append((options.base.odometry, now_s - newest.arrived_s))
        for topic, age in ages:
            if age > options.stale_after_s:
                return (
                    f"topic {topic}: the newest state is {age:.2f} s old "
                    f"(at most {options.stale_after_s:g} s){self._refused(topic)}"
                )
        for topic, kind in self._listeners:
            if not self._node.has_listener(topic, kind):
                return f"topic {topic}: nobody listens for {kind}; is the controller active?"
        return ""

    def _silent(self, topic: str, kind: str, text: str) -> str:
        """A topic on which something is missing, and who publishes on it."""
        wanted, found = self._node.types.hash_of(kind), self._node.publishers(topic)
        for one in found:
            if (one.type, one.type_hash) != (kind, wanted):
                got = f"{one.type} {one.type_hash}"
                return expected(f"topic {topic}: {text}; publisher {one.node}", kind, got)
        if found:
            by = ", ".join(one.node for one in found)
            return f"topic {topic}: {text} (published by {by}){self._refused(topic)}"
        others = ", ".join(self._node.topics(kind)) or "none"
        return (
            f"topic {topic}: {text}; nobody publishes on it in domain {self._options.domain} "
            + (f"(topics of {kind}: {others})")
        )

    def _refused(self, topic: str) -> str:
        why = self._node.refusal(topic)
        return f"; its newest message was dropped: {why}" if why else ""

    def describe(self) -> BackendDescription:
        """The joints that were found, all of robot.yaml's, and the declared ranges of each part."""
        robot = self._robot
        return BackendDescription(
            robot.joint_names,
            robot.passive_joint_names,
            tuple(describe_part(robot, part, self._profile) for part in robot.parts),
            (),
            cameras=(),
            has_task=False,
        )

    def read(self) -> Measurement:
        """The newest states.

        Raises:
            ServiceError: a state is too old, or nobody listens to a command topic any more.
        """
        if problem := self._problem():
            raise ServiceError(f"hal_ros2: {problem}")
        base = self._odometry.newest if self._odometry is not None else None
        others: dict[int, tuple[float, float]] = {}
        if base is not None:
            pairs = zip(base.positions, base.velocities, strict=True)
            for name, (position, velocity) in zip(self._robot.base_joints, pairs, strict=True):
                index = self._robot.joint_names.index(name)
                others[index] = (float(position), float(velocity))
        self._pose = None if base is None else base.pose
        measured = measurement(self._sources, self._states.newest(), others)
        self._check_turns(measured.positions)
        self._measured = measured
        return measured

    def _check_turns(self, positions: FloatArray) -> None:
        """Refuse a joint that is reported in another turn: a hold would lead it back by one."""
        turns = positions[self._turning]
        off = np.abs(turns - self._turns) > np.pi
        if np.any(off):  # what was measured before stays, for the hold
            joint = self._robot.joint_names[self._turning[int(np.argmax(off))]]
            raise ServiceError(
                f"hal_ros2: joint {joint}: reported a turn away from the tick before; its driver "
                "has to count the turns of a continuous joint"
            )
        self._turns = turns

    def transforms(self) -> Sequence[FramePose]:
        """``odom`` to the base frame, and what came on `tf` of the frames wanted from there."""
        base = self._pose or FramePose("odom", self._robot.base_frame, HERE, UPRIGHT)
        return [base, *self._frames.new()]

    def static_transforms(self) -> Sequence[FramePose]:
        """``map -> odom``, unless somebody sends it on `tf`."""
        if "odom" in self._options.frames:
            return []
        return [FramePose("map", "odom", HERE, UPRIGHT)]

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        """As `Backend.apply`: one message for each part that moves, or has just come to rest."""
        positions = self._measured.positions[: self._robot.n_dof]
        if self._odometry is not None:
            self._drive_base(commands)
        for name in self._drives:
            if name in commands and self._at_rest[name] >= REST_PERIODS:
                self._setpoints.stand_at(name, positions)
        before = self._setpoints.positions.copy()
        targets = self._setpoints.advance(commands, positions)
        for name, drive in self._drives.items():
            moved = np.any(targets[drive.joints] != before[drive.joints])
            if self._is_told(name, name in commands or bool(moved)):
                drive.send(targets)

    def _drive_base(self, commands: Mapping[str, PartCommand]) -> None:
        part = self._robot.owner(self._robot.base_joints[0]).name
        assert self._odometry is not None, "asked by the caller"
        assert self._odometry.newest is not None, "there is one from the start on"
        yaw = float(self._odometry.newest.positions[2])
        rates = self._base_drive.advance(commands.get(part), yaw)
        if self._is_told("base", part in commands or bool(rates.any())):
            self._twists.publish(twist_message(self._node.types, rates))

    def _is_told(self, name: str, moves: bool) -> bool:
        self._at_rest[name] = 0 if moves else self._at_rest[name] + 1
        return self._at_rest[name] <= REST_PERIODS

    def task(self) -> None:
        """There is no task to succeed in."""
        return

    def reset(self, seed: int) -> None:
        """Refused: a robot has no episodes."""
        raise ConfigError("hal_ros2: expected a simulator for reset_episode, got a robot")

    def snapshot(self) -> bytes:
        """Nothing to render from."""
        return b""

    def close(self) -> None:
        """Leave the ROS 2 system; a base that may still have a twist is told to stand."""
        try:
            if self._odometry is not None and self._at_rest["base"] <= REST_PERIODS:
                self._twists.publish(twist_message(self._node.types, np.zeros(3)))
        finally:
            self._node.close()
