"""One row of part commands -> the flat float32 vector that ``env.step`` takes.

Pure functions: no simulator, no clock. Where each part sits, and how SI numbers become
controller inputs, is an `ActionMap` built by `fairlead_hal_sim.introspection`.

A part without a command holds by its hold law: a delta or velocity part gets zeros, the
composite switch gets -1.0, a gripper gets its last input again (a grasp is kept).
Indices that belong to no part (the torso) are always 0.0, never a remembered value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead_hal_sim.base_frame import BaseMotion, joint_rates

ActionVector = npt.NDArray[np.float32]

MODE_HOLD = -1.0
"""The composite switch without a command: deltas start from the achieved arm pose."""


@dataclass(frozen=True)
class PartSlot:
    """Where one part sits in the vector and how SI becomes controller input.

    first, stop: half-open range of the vector. ``value = input * scale + offset`` with
    scale and offset of shape ``[stop - first]``; the mode's values are SI.
    hold: input of a part without a command; None keeps the previous vector's.
    joints: indices of the robot's commanded joints the slot drives, in slot order
    (joint modes only). frame: the frame cartesian values must be given in.
    """

    name: str
    simulator_part: str
    first: int
    stop: int
    modes: tuple[ControlMode, ...]
    scale: FloatArray
    offset: FloatArray
    hold: float | None
    joints: tuple[int, ...] = ()
    frame: str = ""

    @property
    def width(self) -> int:
        """Controller inputs of this part."""
        return self.stop - self.first


@dataclass(frozen=True)
class ActionMap:
    """The whole vector: its width, its parts, and the robot's commanded joints in order."""

    width: int
    parts: tuple[PartSlot, ...]
    joint_names: tuple[str, ...]

    @cached_property
    def scale(self) -> FloatArray:
        """Of every input, shape ``[width]``; 1.0 where there is no part."""
        return self._of_inputs(1.0, lambda slot: slot.scale)

    @cached_property
    def offset(self) -> FloatArray:
        """Of every input, shape ``[width]``; 0.0 where there is no part."""
        return self._of_inputs(0.0, lambda slot: slot.offset)

    @cached_property
    def beside_offset(self) -> FloatArray:
        """The number next to each offset, towards 0."""
        return np.nextafter(self.offset, 0.0)

    def _of_inputs(self, elsewhere: float, of: Callable[[PartSlot], FloatArray]) -> FloatArray:
        values = np.full(self.width, elsewhere)
        for slot in self.parts:
            values[slot.first : slot.stop] = of(slot)
        return values

    def slot(self, part: str) -> PartSlot:
        """The slot of a part; the one place where a part's position is looked up.

        Raises:
            ConfigError: naming the parts there are.
        """
        for slot in self.parts:
            if slot.name == part:
                return slot
        names = [slot.name for slot in self.parts]
        raise ConfigError(expected("packing", "a part of this robot", repr(part), names))


def pack(
    commands: Mapping[str, PartCommand],
    action_map: ActionMap,
    previous: ActionVector,
    base_motion: BaseMotion | None = None,
) -> ActionVector:
    """Pack one row of commands into a fresh float32 vector of shape ``[width]``.

    Args:
        commands: by part name; absent parts hold.
        previous: the vector packed for the tick before (zeros after a reset).
        base_motion: how base commands become base motion now; needed by body_twist.

    Raises:
        ConfigError: for a part, mode, width or frame that the simulator's controllers do not take.
    """
    for name in commands:
        action_map.slot(name)
    vector = np.zeros(action_map.width, dtype=np.float32)
    values = np.zeros(action_map.width)
    told = np.zeros(action_map.width, dtype=bool)
    for slot in action_map.parts:
        command = commands.get(slot.name)
        if command is not None:
            _tell(slot, command, action_map, base_motion, values, told)
        elif slot.hold is None:
            vector[slot.first : slot.stop] = previous[slot.first : slot.stop]
        else:
            vector[slot.first : slot.stop] = slot.hold
    vector[told] = _inputs(values, action_map)[told]
    return vector


def _tell(
    slot: PartSlot,
    command: PartCommand,
    action_map: ActionMap,
    base_motion: BaseMotion | None,
    values: FloatArray,
    told: npt.NDArray[np.bool_],
) -> None:
    """Put one part's SI values where its inputs are, and note which inputs it drives."""
    _check_command(slot, command)
    driven: slice | npt.NDArray[np.intp] = slice(slot.first, slot.stop)
    width = slot.width
    if command.mode is ControlMode.JOINT_VELOCITY:
        own, joints = _joint_values(slot, command, action_map.joint_names)
        driven, width = slot.first + joints, len(joints)
    elif command.mode is ControlMode.BODY_TWIST:
        own = _twist_rates(slot, command, base_motion)
    else:
        own = command.values
    if len(own) != width:
        raise ConfigError(
            expected(
                f"packing: part {slot.name}",
                f"{width} values for inputs [{slot.first}, {slot.stop}) of simulator part "
                f"{slot.simulator_part!r}",
                len(own),
            )
        )
    values[driven], told[driven] = own, True


def _inputs(values: FloatArray, action_map: ActionMap) -> ActionVector:
    """Controller inputs: the inverse of the SI scaling, rounded to float32.

    Rounding the float64 quotient restores the float32 a policy emitted, bit for bit. An offset
    itself is +0.0, and the number next to it, towards 0, is -0.0, as dispatch writes it.
    """
    offset = action_map.offset
    inputs = ((values - offset) / action_map.scale).astype(np.float32)
    inputs[(values == offset) & (offset != 0.0)] = 0.0
    inputs[(values == action_map.beside_offset) & (offset != 0.0)] = -0.0
    return inputs


def _check_command(slot: PartSlot, command: PartCommand) -> None:
    who = f"packing: part {slot.name}"
    if command.mode not in slot.modes:
        names = [mode.yaml_name for mode in slot.modes]
        raise ConfigError(expected(who, "a mode it supports", command.mode.yaml_name, names))
    if slot.frame and not command.mode.is_joint_mode and command.frame_id != slot.frame:
        raise ConfigError(expected(who, f"frame {slot.frame!r}", repr(command.frame_id)))


def _joint_values(
    slot: PartSlot, command: PartCommand, joint_names: tuple[str, ...]
) -> tuple[FloatArray, npt.NDArray[np.intp]]:
    """Values of the active joints, and which of the slot's inputs they drive.

    That they are this part's the host has checked (`fairlead.hal.backend`).
    """
    if not command.active:
        own = [joint_names[joint] for joint in slot.joints]
        raise ConfigError(
            expected(f"packing: part {slot.name}", "at least one active joint", "none", own)
        )
    driven = np.array([slot.joints.index(joint) for joint in command.active], dtype=np.intp)
    return command.values[list(command.active)], driven


def _twist_rates(
    slot: PartSlot, command: PartCommand, base_motion: BaseMotion | None
) -> FloatArray:
    who = f"packing: part {slot.name}"
    if base_motion is None:
        raise ConfigError(expected(who, "a base that can follow a body_twist", "none"))
    rates = joint_rates(command.values, base_motion)
    limits = np.abs(slot.scale)
    if (np.abs(rates) > limits * (1 + 1e-9)).any():
        raise ConfigError(
            expected(
                who,
                f"a body_twist within joint rates of +-{limits.tolist()}",
                f"{np.round(rates, 4).tolist()} needed for {command.values.tolist()}",
            )
        )
    return rates
