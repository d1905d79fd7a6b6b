"""What a robot manifest groups joints into: parts, end effectors, simulator names."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from fairlead.errors import expected
from fairlead.modes import ControlMode

HoldLaw = Literal["keep_position", "zero_delta", "ramp_to_zero", "keep_command", "write_default"]
MODE_NAMES = tuple(mode.yaml_name for mode in ControlMode)


class Part(BaseModel):
    """A group of joints that is commanded, claimed and held as one.

    hold: ``keep_position`` keeps the last setpoint; ``zero_delta`` sends zero deltas or
    twists without moving the goal; ``ramp_to_zero`` brings velocities to zero;
    ``keep_command`` repeats the last command (a grasp is kept); ``write_default`` writes
    the simulator's default.
    simulator_part: name of the simulator controller's part, "" where it has none.
    end_effector: the end effector its cartesian or gripper modes move, None if it has none.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    joints: tuple[str, ...]
    simulator_part: str
    hold: HoldLaw
    modes: tuple[str, ...] = Field(min_length=1)
    end_effector: str | None = None

    @field_validator("modes")
    @classmethod
    def _known_modes(cls, modes: tuple[str, ...]) -> tuple[str, ...]:
        for mode in modes:
            if mode not in MODE_NAMES:
                raise ValueError(expected("modes", "a control mode", repr(mode), MODE_NAMES))
            if modes.count(mode) > 1:
                raise ValueError(expected("modes", "each once", repr(list(modes))))
        return modes

    @property
    def control_modes(self) -> tuple[ControlMode, ...]:
        """The declared modes, in the order of the manifest."""
        return tuple(ControlMode[mode.upper()] for mode in self.modes)

    @property
    def only_grips(self) -> bool:
        """Whether it is told openings and nothing else."""
        return set(self.modes) <= {"gripper_binary", "gripper_position"}


class EndEffector(BaseModel):
    """A tool: the frame commands move, and the joint that opens it (if it is actuated).

    A hand (a part with ``dex_hand_joint`` has it) is actuated without a ``gripper_joint``.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    tool_frame: str
    gripper_joint: str | None = None
    actuated: bool


class FrameTolerance(BaseModel):
    """How far a frame of the simulator may be from where the description has it."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    distance_m: float = Field(default=1e-4, gt=0, le=0.01, allow_inf_nan=False)
    angle_rad: float = Field(default=1e-4, gt=0, le=0.02, allow_inf_nan=False)


class SimulatorNames(BaseModel):
    """How the simulator calls what the manifest names.

    base_body: the body whose pose is ``base_link``; its pose is ``odom -> base_link``.
    joints: simulator joints of each joint, one that is not named here being called alike; where
    there are two, the joint is their difference (a two-finger gripper's total opening).
    frames: ``body:NAME`` or ``site:NAME`` of each frame the description shares with the
    simulator.
    frame_tolerance: how well both have to agree on where those are.
    model: an MJCF file in the robot's folder, or ``robosuite:ROBOT`` or
    ``robosuite:ROBOT+GRIPPER``; None: ``<robot>.xml``, where there is one.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    base_body: str
    joints: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    frames: dict[str, str]
    frame_tolerance: FrameTolerance = FrameTolerance()
    model: str | None = None

    @field_validator("frames")
    @classmethod
    def _bodies_and_sites(cls, frames: dict[str, str]) -> dict[str, str]:
        for name, reference in frames.items():
            if not reference.startswith(("body:", "site:")):
                raise ValueError(expected(name, "body:NAME or site:NAME", repr(reference)))
        return frames
