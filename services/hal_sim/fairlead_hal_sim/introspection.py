"""What the running simulator does with its action vector, asked of it and not assumed."""

from __future__ import annotations

from typing import Any

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray, HalPart, ModeRange, pack_floats
from fairlead.modes import ControlMode
from fairlead_hal_sim.joints import ArmJoints, JointSource, RobotJoints, finger_range, slides
from fairlead_hal_sim.packing import MODE_HOLD, ActionMap, PartSlot


def simulator_slot(composite: Any, part: str) -> tuple[int, int]:
    """Half-open range of one simulator part in the action vector.

    Raises:
        ConfigError: naming the parts the controller has.
    """
    slots = composite._action_split_indexes
    if part not in slots:
        raise ConfigError(expected("hal_sim", "a simulator part", repr(part), slots))
    first, stop = slots[part]
    return int(first), int(stop)


def find_action_map(env: Any, joints: RobotJoints) -> ActionMap:
    """Parts of the environment's first robot, in order: arms, grippers, base, composite."""
    composite = env.robots[0].composite_controller
    several = len(joints.arms) > 1
    slots = []
    for arm in joints.arms:
        prefix = f"{arm.side}_" if several else ""
        slots.append(_arm_slot(composite, prefix + "arm", arm.side))
        (opening,) = (one for one in joints.commanded if one.name == arm.gripper)
        slots.append(_gripper_slot(env, composite, prefix + "gripper", arm, opening))
    if joints.base:
        slots.append(_base_slot(composite, joints))
    last = max(stop for _, stop in composite._action_split_indexes.values())
    width = int(composite.action_limits[0].size)
    if width == last + 1:
        slots.append(_composite_slot(last))
    elif width != last:
        raise ConfigError(expected("hal_sim", f"an action of {last} or {last + 1}", width))
    return ActionMap(width=width, parts=tuple(slots), joint_names=joints.names)


def describe_parts(
    action_map: ActionMap, joints: RobotJoints, dead_band: FloatArray
) -> tuple[HalPart, ...]:
    """The parts with their SI command ranges, as they go into ``hal/status``."""
    grippers = {f"{arm.side}_gripper": (arm.gripper,) for arm in joints.arms}
    arms = {arm.side: arm.arm for arm in joints.arms}
    owned = {"base": joints.base, **grippers, **arms}
    return tuple(
        HalPart(
            name=slot.name,
            simulator_part=slot.simulator_part,
            joints=owned.get(slot.simulator_part, ()),
            ranges=tuple(_mode_range(slot, mode, dead_band) for mode in slot.modes),
        )
        for slot in action_map.parts
    )


def _mode_range(slot: PartSlot, mode: ControlMode, dead_band: FloatArray) -> ModeRange:
    """Range of every controlled value at inputs -1 and +1."""
    reach = np.abs(slot.scale)
    lower, upper = slot.offset - reach, slot.offset + reach
    if mode is ControlMode.BODY_TWIST:
        # In any direction: the fastest diagonal one slide can do, after friction.
        linear = float(np.min(reach[:2] - dead_band[:2]) / np.sqrt(2.0))
        yaw = float(reach[2] - dead_band[2])
        upper = np.array([linear, linear, 0.0, 0.0, 0.0, yaw])
        lower = -upper
    return ModeRange(mode=mode, lower=pack_floats(lower), upper=pack_floats(upper))


def _arm_slot(composite: Any, name: str, part: str) -> PartSlot:
    controller = composite.part_controllers[part]
    kind = getattr(controller, "name", type(controller).__name__)
    if (
        kind != "OSC_POSE"
        or controller.input_type != "delta"
        or controller.impedance_mode != "fixed"
    ):
        raise ConfigError(
            expected(f"hal_sim: part {name}", "a fixed-gain delta controller", kind, ["OSC_POSE"])
        )
    if controller.input_ref_frame != "base":
        raise ConfigError(
            expected(f"hal_sim: part {name}", "deltas in 'base'", repr(controller.input_ref_frame))
        )
    scale, offset = _affine(controller)
    return _slot(composite, name, part, (ControlMode.CARTESIAN_DELTA,), scale, offset, 0.0,
                 frame="base_link")  # fmt: skip


def _gripper_slot(
    env: Any, composite: Any, name: str, arm: ArmJoints, opening: JointSource
) -> PartSlot:
    """Input +1 closes and -1 opens; only the sign counts to the simulator's gripper."""
    ranges = [finger_range(env, joint) for joint in opening.simulator_joints]
    if all(slides(env, joint) for joint in opening.simulator_joints):
        open_at = sum(max(abs(low), abs(high)) for low, high in ranges)
        closed_at = sum(min(abs(low), abs(high)) for low, high in ranges)
    else:
        (low, high) = ranges[0]
        open_at, closed_at = (low, high) if _turns_up(env, arm.side) else (high, low)
    return _slot(
        composite,
        name,
        f"{arm.side}_gripper",
        (ControlMode.GRIPPER_POSITION,),
        np.array([(closed_at - open_at) / 2]),
        np.array([(closed_at + open_at) / 2]),
        None,
    )


def _turns_up(env: Any, side: str) -> bool:
    """Whether closing turns the first driven knuckle to larger angles: asked of the gripper."""
    gripper = env.robots[0].gripper[side]
    before = gripper.current_action
    gripper.current_action = np.zeros(gripper.dof)
    closing = gripper.format_action(np.ones(gripper.dof))
    gripper.current_action = before
    return bool(closing[0] > 0.0)


def _base_slot(composite: Any, joints: RobotJoints) -> PartSlot:
    controller = composite.part_controllers["base"]
    kind = getattr(controller, "name", type(controller).__name__)
    if kind != "JOINT_VELOCITY":
        raise ConfigError(
            expected("hal_sim: part base", "a base controller", kind, ["JOINT_VELOCITY"])
        )
    low, high = np.asarray(controller.actuator_min), np.asarray(controller.actuator_max)
    return _slot(
        composite,
        "base",
        "base",
        (ControlMode.JOINT_VELOCITY, ControlMode.BODY_TWIST),
        (high - low) / 2,
        (high + low) / 2,
        0.0,
        joints=joints.indices(joints.base),
        frame="base_link",
    )


def _composite_slot(index: int) -> PartSlot:
    """The switch after all parts that a hybrid mobile base controller reads."""
    return PartSlot(
        name="composite",
        simulator_part="",
        first=index,
        stop=index + 1,
        modes=(ControlMode.COMPOSITE_MODE,),
        scale=np.array([1.0]),
        offset=np.array([0.0]),
        hold=MODE_HOLD,
    )


def _slot(
    composite: Any,
    name: str,
    simulator_part: str,
    modes: tuple[ControlMode, ...],
    scale: FloatArray,
    offset: FloatArray,
    hold: float | None,
    joints: tuple[int, ...] = (),
    frame: str = "",
) -> PartSlot:
    first, stop = simulator_slot(composite, simulator_part)
    if stop - first != len(scale):
        raise ConfigError(
            expected(
                f"hal_sim: part {name}",
                f"{len(scale)} inputs for simulator part {simulator_part!r}",
                f"{stop - first} at [{first}, {stop})",
            )
        )
    return PartSlot(name, simulator_part, first, stop, modes, scale, offset, hold, joints, frame)


def _affine(controller: Any) -> tuple[FloatArray, FloatArray]:
    """Scale and offset of a controller that maps inputs linearly onto SI outputs."""
    low_in, high_in = np.asarray(controller.input_min), np.asarray(controller.input_max)
    low, high = np.asarray(controller.output_min), np.asarray(controller.output_max)
    scale = (high - low) / (high_in - low_in)
    return scale, low - low_in * scale
