"""``robots/<id>/robot.yaml``: what a robot is and what it may do."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection
from functools import cached_property
from pathlib import Path, PurePosixPath

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from fairlead.errors import ConfigError, expected
from fairlead.keys import check_name
from fairlead.paths import robot_dir
from fairlead.regular_file import regular
from fairlead.robot.interpolation import Interpolation
from fairlead.robot.joint import Joint
from fairlead.robot.part import EndEffector, Part, SimulatorNames
from fairlead.robot.rules import CONFIRMED_ONLY, HomePose, open_problems, reference_problems
from fairlead.robot.safety_profile import ProfileName, SafetyProfile
from fairlead.yaml_file import load_yaml, locator


class RobotManifest(BaseModel):
    """One robot. Joint order here is wire order: commanded joints, then passive ones."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    id: str
    description: str = Field(description="URDF file in the robot's folder")
    capsules: str = Field(description="file of the robot's shape, in its folder")
    control_period_ms: float = Field(ge=1, le=1000)
    base_frame: str
    interpolation: Interpolation = Field(
        default="linear", description="how drives that are faster than the rows are told to go"
    )
    joints: tuple[Joint, ...] = Field(min_length=1)
    passive_joints: tuple[Joint, ...] = ()
    base_joints: tuple[str, ...] = ()
    parts: tuple[Part, ...] = Field(min_length=1)
    end_effectors: tuple[EndEffector, ...] = ()
    tracked_frames: tuple[str, ...] = Field(
        default=(), description="frames beside the description's that a HAL or tracker publishes"
    )
    home: HomePose | None = Field(default=None, description="where the robot rests")
    simulator: SimulatorNames | None = None
    no_collision_geometry: dict[str, str] = Field(
        default_factory=dict, description="links without capsules, and why that is no loss"
    )
    to_confirm: dict[str, str] = Field(
        default_factory=dict,
        description="numbers that a person has yet to give or confirm, by key, and why",
    )
    safety: dict[ProfileName, SafetyProfile] = Field(min_length=1)

    @field_validator("id")
    @classmethod
    def _key_chunk(cls, value: str) -> str:
        try:
            return check_name("robot id", value)
        except ConfigError as error:
            raise ValueError(str(error)) from None

    @field_validator("no_collision_geometry")
    @classmethod
    def _says_why(cls, links: dict[str, str]) -> dict[str, str]:
        for link, why in links.items():
            if not why.strip():
                raise ValueError(f"{link}: expected why no capsule is no loss, got {why!r}")
        return links

    @field_validator("description", "capsules")
    @classmethod
    def _in_the_folder(cls, value: str) -> str:
        path = PurePosixPath(value)
        if not value.isprintable() or path.is_absolute() or ".." in path.parts or len(value) > 200:
            raise ValueError(f"expected a file in the robot's folder, got {value!r}")
        return value

    @model_validator(mode="after")
    def _references_resolve(self) -> RobotManifest:
        problems = reference_problems(
            joints=self.joints,
            passive_joints=self.passive_joints,
            base_joints=self.base_joints,
            parts=self.parts,
            end_effectors=self.end_effectors,
            home=self.home,
            simulator=self.simulator,
            safety=self.safety,
        )
        if self.to_confirm:
            problems += open_problems(self.model_dump(), self.to_confirm)
        if problems:
            raise ValueError("\n".join(problems))
        return self

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Commanded joints in wire order."""
        return tuple(joint.name for joint in self.joints)

    @property
    def passive_joint_names(self) -> tuple[str, ...]:
        """Joints that are measured and not commanded, in wire order."""
        return tuple(joint.name for joint in self.passive_joints)

    @property
    def measured_joint_names(self) -> tuple[str, ...]:
        """Order of the blocks in a `JointState`: commanded, then passive joints."""
        return self.joint_names + self.passive_joint_names

    @property
    def part_names(self) -> tuple[str, ...]:
        """Parts in the order in which messages number them."""
        return tuple(part.name for part in self.parts)

    @property
    def n_dof(self) -> int:
        """Number of commanded joints."""
        return len(self.joints)

    @property
    def tick_period_ns(self) -> int:
        """The control period, one tick [ns]."""
        return round(self.control_period_ms * 1e6)

    @cached_property
    def robot_hash(self) -> bytes:
        """SHA-256 of what the robot is: this manifest and its description file.

        The safety block and the robot's shape are left out: they have a hash of their own for each
        profile, that of the gate's file. So are tracked frames, which are of things around it,
        where it rests, sources and what is to be confirmed, which are prose, and what only the
        comparison with a simulator's model goes by.
        Everything else counts, limits, hold laws and frames too: two processes that disagree on
        one of them mean two robots.

        Raises:
            ConfigError: if the robot has no folder or no description file.
        """
        identity = self.model_dump(
            mode="json",
            exclude={
                "safety": True,
                "capsules": True,
                "no_collision_geometry": True,
                "tracked_frames": True,
                "home": True,
                "to_confirm": True,
                "simulator": {"frame_tolerance", "model"},
                "joints": {"__all__": {"source"}},
                "passive_joints": {"__all__": {"source"}},
            },
        )
        if self.interpolation == "linear":  # as it was before there was another
            del identity["interpolation"]
        identity["description"] = hashlib.sha256(self._description_bytes()).hexdigest()
        text = json.dumps(identity, separators=(",", ":"), sort_keys=True, ensure_ascii=True)
        return hashlib.sha256(text.encode()).digest()

    def _description_bytes(self) -> bytes:
        path = self.description_path()
        try:
            return regular(path).read_bytes()
        except OSError as error:
            raise ConfigError(
                f"robot {self.id}: no description file {path} ({error.strerror})"
            ) from None

    def part(self, name: str) -> Part:
        """The part of that name; `ConfigError` lists the parts there are."""
        for part in self.parts:
            if part.name == name:
                return part
        raise ConfigError(expected(f"robot {self.id}", "a part", repr(name), self.part_names))

    def claimed_parts(self, commanded: Collection[str]) -> tuple[str, ...]:
        """The parts to claim in order to command some: with an arm goes its composite switch.

        What the switch says changes what the arm's commands mean, so nobody else may turn it.
        """
        with_arm = self.has_arm(commanded)
        return tuple(
            part.name
            for part in self.parts
            if part.name in commanded or (with_arm and "composite_mode" in part.modes)
        )

    def has_arm(self, parts: Collection[str]) -> bool:
        """Whether one of these parts is an arm."""
        arms = {joint.name for joint in self.joints if joint.role == "arm"}
        return any(part.name in parts and arms & set(part.joints) for part in self.parts)

    def owner(self, joint: str) -> Part:
        """The part that commands a joint."""
        return next(part for part in self.parts if joint in part.joints)

    def joint(self, name: str) -> Joint:
        """The commanded or passive joint of that name; `ConfigError` lists those there are."""
        for joint in self.joints + self.passive_joints:
            if joint.name == name:
                return joint
        raise ConfigError(
            expected(f"robot {self.id}", "a joint", repr(name), self.measured_joint_names)
        )

    def simulator_joints(self, joint: str) -> tuple[str, ...]:
        """What the simulator calls a joint: two names are the fingers of an opening."""
        named = {} if self.simulator is None else self.simulator.joints
        return named.get(joint, (joint,))

    def end_effector(self, name: str) -> EndEffector:
        """The end effector of that name; `ConfigError` lists those there are."""
        for tool in self.end_effectors:
            if tool.name == name:
                return tool
        valid = [tool.name for tool in self.end_effectors]
        raise ConfigError(expected(f"robot {self.id}", "an end effector", repr(name), valid))

    def profile(self, name: str) -> SafetyProfile:
        """The safety block of a profile; `ConfigError` lists those there are."""
        for known, block in self.safety.items():
            if known == name:
                return block
        raise ConfigError(
            expected(f"robot {self.id}", "a safety profile", repr(name), sorted(self.safety))
        )

    def open_numbers(self, profile: str) -> str:
        """What keeps a profile from being compiled and started, in words; "" if nothing does."""
        if profile != CONFIRMED_ONLY or not self.to_confirm:
            return ""
        return (
            f"robot {self.id}: profile {profile}: {len(self.to_confirm)} entries of robot.yaml are "
            f"still to be confirmed: {', '.join(self.to_confirm)}; correct each, delete its line "
            f"in to_confirm, then: fairlead robot compile {self.id}"
        )

    def check_confirmed(self, profile: str) -> None:
        """Whether a profile may be used.

        Raises:
            ConfigError: it is for a real robot; naming every entry that is still open.
        """
        problem = self.open_numbers(profile)
        if problem:
            raise ConfigError(problem)

    def description_path(self) -> Path:
        """The URDF file."""
        return robot_dir(self.id) / self.description


def load_robot(robot: str) -> RobotManifest:
    """Load ``robots/<robot>/robot.yaml``.

    Raises:
        ConfigError: naming the file and everything in it that does not fit.
    """
    folder = robot_dir(robot)
    manifest = load_yaml(folder / "robot.yaml", RobotManifest)
    if manifest.id != robot:
        where = locator(folder / "robot.yaml")(("id",))
        raise ConfigError(f"{where}id: expected {robot!r}, the folder's name, got {manifest.id!r}")
    if not manifest.description_path().is_file():
        raise ConfigError(f"robot {robot}: no description file {manifest.description_path()}")
    return manifest
