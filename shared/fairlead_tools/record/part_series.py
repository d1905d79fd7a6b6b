"""What was asked, released and measured of each part, tick by tick. Pure functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from fairlead.messages import ActionPart, FloatArray, Hold, floats
from fairlead.modes import GATED_MODES, ControlMode
from fairlead.robot.link_poses import rotation_matrix
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.safety_profile import SafetyProfile
from fairlead_tools.record.measured import Curve, Measured, rotation_vector
from fairlead_tools.record.run_log import Run

_AXES = ("x", "y", "z", "turn x", "turn y", "turn z")
_RATES = frozenset({
    ControlMode.JOINT_VELOCITY, ControlMode.CARTESIAN_DELTA, ControlMode.CARTESIAN_TWIST,
    ControlMode.BODY_TWIST,
})  # fmt: skip
_SWITCHES = frozenset({
    ControlMode.DEX_HAND_JOINT, ControlMode.GRIPPER_BINARY, ControlMode.GRIPPER_POSITION,
    ControlMode.COMPOSITE_MODE,
})  # fmt: skip
_STILL = 1e-9


@dataclass
class Panel:
    """Three curves of one quantity of one part, in one unit and one frame.

    frame: whose axes they are along, "" for a joint's own.
    gain: which share of what was released the robot is declared to make within a tick, from the
        least to the most; None where a target, not a motion, is asked.
    carried: ticks in which a base moved the part. An arm's controller keeps the tool where it is
        in the world, so that it moves in the base's frame by more than what was asked; neither
        gain nor share is of these ticks.
    switches: it changes at once: a gripper, a hand or a switch.
    """

    part: int
    name: str
    unit: str
    frame: str
    gain: tuple[float, float] | None = None
    carried: frozenset[int] = frozenset()
    switches: bool = False
    asked: Curve = field(default_factory=dict)
    released: Curve = field(default_factory=dict)
    measured: Curve = field(default_factory=dict)

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to see: no motion was asked, or the number is not measured."""
        asked = self.asked.values()
        return (self.gain is not None and not any(abs(value) > _STILL for value in asked)) or (
            not self.measured and len(set(asked)) <= 1
        )

    @property
    def share(self) -> float | None:
        """Which share of what was released was made: the slope through 0 of measured over it."""
        pairs = [
            (told, self.measured[tick])
            for tick, told in self.released.items()
            if tick in self.measured and tick not in self.carried and not math.isnan(told)
        ]
        square = math.fsum(told * told for told, _ in pairs)
        if self.gain is None or square <= _STILL:
            return None
        return math.fsum(told * made for told, made in pairs) / square


@dataclass(frozen=True)
class _Quantity:
    """One number of a mode's row, and the measured number to hold it against."""

    name: str
    unit: str
    frame: str
    of_row: Callable[[int, FloatArray], float]
    measured: Curve


def panels(run: Run, robot: RobotManifest) -> list[Panel]:
    """One panel for each quantity that was commanded, parts in robot order; none is empty.

    Rows are released from the first to the last tick that the chunk's first verdict names.
    """
    safety = robot.profile(run.header.profile)
    series = _Series(robot, safety, Measured(run.joints, robot, safety))
    for chunk, released in run.released():
        for part in chunk.parts:
            series.add(part, chunk.start_tick, released)
    found = sorted(series.panels.items(), key=lambda item: item[0][0])
    return [panel for _, panel in found if not panel.is_empty]


def held_ticks(run: Run, part: int | None = None) -> dict[int, Hold]:
    """Ticks in which a part held, and why; without one: all parts, and why the first did."""
    return {
        state.tick - 1: Hold(state.acted[part or 0].hold)
        for state in run.joints
        if state.acted
        and all(
            one.hold != Hold.NONE for one in (state.acted if part is None else [state.acted[part]])
        )
    }


class _Series:
    """Panels by part and quantity, filled chunk by chunk."""

    def __init__(self, robot: RobotManifest, safety: SafetyProfile, measured: Measured) -> None:
        self.panels: dict[tuple[int, str], Panel] = {}
        self._robot, self._safety, self._measured = robot, safety, measured
        self._known: dict[tuple[object, ...], list[_Quantity]] = {}
        self._first_turn: dict[int, FloatArray] = {}
        turns = safety.base is not None and safety.base.command_frame == "against_yaw"
        self._yaw = measured.yaw() if turns else {}
        self._driven = measured.base_moves()

    def add(self, part: ActionPart, first_tick: int, released: range) -> None:
        """What one chunk asked of one part; nothing if it is not made for this robot."""
        if not self._fits(part):
            return  # the gate refused it, which is marked
        mode = ControlMode(part.mode)
        rows = floats(part.values, mode.width(self._robot.n_dof))
        key = (part.part, mode, part.frame_id, part.active)
        if key not in self._known:
            self._known[key] = list(self._quantities(part, mode, rows[0]))
        for quantity in self._known[key]:
            panel = self._panel(part.part, mode, quantity)
            for tick, row in enumerate(rows, first_tick):
                value = panel.asked[tick] = quantity.of_row(tick, row)
                if tick in released:
                    panel.released[tick] = value

    def _fits(self, part: ActionPart) -> bool:
        if part.part >= len(self._robot.parts):
            return False
        if part.mode not in self._robot.parts[part.part].control_modes:
            return False
        mode, n_dof = ControlMode(part.mode), self._robot.n_dof
        return (
            mode in GATED_MODES
            and len(part.values) > 0
            and len(part.values) % (8 * mode.width(n_dof)) == 0
            and max(part.active, default=0) < n_dof
            and (not mode.is_tool_mode or part.frame_id in self._measured.frames)
        )

    def _panel(self, part: int, mode: ControlMode, quantity: _Quantity) -> Panel:
        key = (part, f"{mode.yaml_name} {quantity.name} {quantity.frame}")
        if key not in self.panels:
            name = self._robot.parts[part].name
            limits = getattr(self._safety.parts[name], mode.yaml_name, None)
            gain = getattr(limits, "gain", (0.0, 1.0)) if mode in _RATES else None
            self.panels[key] = Panel(
                part, f"{name} {quantity.name}", quantity.unit, quantity.frame, gain,
                self._driven if mode.is_tool_mode else frozenset(), mode in _SWITCHES,
                measured=quantity.measured,
            )  # fmt: skip
        return self.panels[key]

    def _quantities(
        self, part: ActionPart, mode: ControlMode, first: FloatArray
    ) -> Iterable[_Quantity]:
        period_s = self._robot.tick_period_ns / 1e9
        if mode is ControlMode.CARTESIAN_DELTA:
            curves = self._measured.tool_motion(self._tool(part), part.frame_id)
            yield from _along(curves, ("mm per tick", "mrad per tick"), part.frame_id, 1e3)
        elif mode is ControlMode.CARTESIAN_TWIST:
            curves = self._measured.tool_motion(self._tool(part), part.frame_id)
            rates = [{tick: value / period_s for tick, value in one.items()} for one in curves]
            yield from _along(rates, ("m/s", "rad/s"), part.frame_id, 1.0)
        elif mode is ControlMode.BODY_TWIST:
            frame = self._robot.base_frame
            yield from _along(self._measured.base_twist(), ("m/s", "rad/s"), frame, 1.0)
        elif mode is ControlMode.CARTESIAN_POSE:
            yield from self._pose(part, first)
        elif mode.is_joint_mode:
            yield from (self._joint(index, mode) for index in part.active)
        else:
            yield self._single(part, mode)

    def _tool(self, part: ActionPart) -> str:
        name = self._robot.parts[part.part].end_effector
        assert name is not None, "the gate admits no tool motion of a part without a tool"
        return self._robot.end_effector(name).tool_frame

    def _pose(self, part: ActionPart, first: FloatArray) -> Iterator[_Quantity]:
        since = self._first_turn.setdefault(part.part, rotation_matrix(first[3:]))
        curves = self._measured.tool_pose(self._tool(part), part.frame_id, since)
        for axis, name in enumerate(_AXES):

            def of_row(_: int, row: FloatArray, axis: int = axis) -> float:
                if axis < 3:
                    return float(row[axis])
                return float(rotation_vector(rotation_matrix(row[3:]) @ since.T)[axis - 3])

            unit = "m" if axis < 3 else "rad"
            yield _Quantity(name, unit, part.frame_id, of_row, curves[axis])

    def _joint(self, index: int, mode: ControlMode) -> _Quantity:
        joint = self._robot.joints[index]
        length = "m" if joint.type == "prismatic" else "rad"
        slides = self._robot.base_joints[:2] if self._yaw else ()
        if mode is not ControlMode.JOINT_VELOCITY:
            curve = self._measured.position(joint.name)
            return _Quantity(joint.name, length, "", lambda _, row: float(row[index]), curve)
        curve, unit = self._measured.velocity(joint.name), f"{length}/s"
        if joint.name not in slides:
            return _Quantity(joint.name, unit, "", lambda _, row: float(row[index]), curve)
        x, y = (self._robot.joint_names.index(name) for name in slides)

        def along_slide(tick: int, row: FloatArray) -> float:
            """Told against the base's yaw; the slide is along odom."""
            yaw = self._yaw.get(tick, math.nan)
            if index == x:
                return float(math.cos(yaw) * row[x] + math.sin(yaw) * row[y])
            return float(math.cos(yaw) * row[y] - math.sin(yaw) * row[x])

        return _Quantity(joint.name, unit, "odom", along_slide, curve)

    def _single(self, part: ActionPart, mode: ControlMode) -> _Quantity:
        """A gripper or a switch: one number a row."""
        declared = self._robot.parts[part.part]
        tool = self._robot.end_effector(declared.end_effector) if declared.end_effector else None
        joint = tool.gripper_joint if tool is not None else None
        curve = self._measured.position(joint) if joint is not None else {}
        if mode is ControlMode.GRIPPER_POSITION:
            if joint is not None and self._robot.joint(joint).unit == "rad":
                return _Quantity("opening", "rad", "", lambda _, row: float(row[0]), curve)
            opening = {tick: 1e3 * value for tick, value in curve.items()}
            return _Quantity("opening", "mm", "", lambda _, row: 1e3 * float(row[0]), opening)
        if mode is ControlMode.GRIPPER_BINARY:
            most = self._robot.joint(joint).upper if joint is not None else 1.0
            closed = {tick: 1.0 - value / most for tick, value in curve.items()}
            return _Quantity("closed", "share", "", lambda _, row: float(row[0]), closed)
        return _Quantity(mode.yaml_name, "", "", lambda _, row: float(row[0]), {})


def _along(
    curves: list[Curve], units: tuple[str, str], frame: str, scale: float
) -> Iterator[_Quantity]:
    for axis, (name, curve) in enumerate(zip(_AXES, curves, strict=True)):

        def of_row(_: int, row: FloatArray, axis: int = axis) -> float:
            return scale * float(row[axis])

        scaled = {tick: scale * value for tick, value in curve.items()}
        yield _Quantity(name, units[axis // 3], frame, of_row, scaled)
