"""What the HAL says of itself, and its ticks while nothing moves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from fairlead.messages import FloatArray, HalStatus, floats
from fairlead.modes import ControlMode
from fairlead.robot.command_ranges import command_range
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.conformance.control import JITTER_PERCENTILE, Lateness
from fairlead_tools.conformance.heard_states import Heard
from fairlead_tools.conformance.row import Check, Row
from fairlead_tools.conformance.stage import Stage

DESCRIPTION = Check(
    "description", "id, hash, period, joints and parts in the order of robot.yaml", "robot.yaml",
    "return what robot.yaml declares from describe(), or correct robot.yaml",
)  # fmt: skip
MODES = Check(
    "modes", "each part's modes, and no other", "robot.yaml: modes",
    "describe() names the modes that apply() can do, and robot.yaml has the same",
)  # fmt: skip
RANGE_FACTOR = 2.0
TINY = 1e-6
RANGES = Check(
    "SI ranges", f"the declared command ranges, within a factor of {RANGE_FACTOR:g}",
    "robot.yaml: safety limits; factor: own choice",
    "convert to SI units in describe(); describe_part() does it",
)  # fmt: skip
STATES = Check(
    "joint states", "every joint finite, one session, ticks one by one", "docs/wire-format.md",
    "read() returns commanded joints, then passive ones; no tick is left out or sent twice",
)  # fmt: skip
POSITIONS = Check(
    "SI positions", "every joint within its limits and tolerance, in every state",
    "robot.yaml: lower, upper, tolerance",
    "read() returns rad and m; a gripper its total opening",
)  # fmt: skip
TURNS = Check(
    "turns", "a continuous joint's position goes on beyond half a turn",
    "shared/fairlead/hal/backend.py: read",
    "read() counts turns: add one wherever the driver's position jumps by one",
)  # fmt: skip
RATE = Check(
    "tick rate", "", "robot.yaml: control_period_ms; 10 %: own choice",
    "leave pacing to the host; a backend must return well within a period",
)  # fmt: skip
JITTER = Check(
    "jitter", "", "half a period: own choice; the control is a process that only sleeps",
    "read() and apply() must take the same time in each tick; see realtime_priority",
)  # fmt: skip
RATE_SHARE = 0.1
JITTER_SHARE = 0.5


def described_modes(robot: RobotManifest, hal: HalStatus) -> dict[str, list[ControlMode]]:
    """By part, the modes of robot.yaml that the HAL has, too."""
    told = {part.name: [one.mode for one in part.ranges] for part in hal.parts}
    return {
        part.name: [mode for mode in part.control_modes if mode in told.get(part.name, ())]
        for part in robot.parts
    }


def description(robot: RobotManifest, hal: HalStatus, robot_id: str) -> Row:
    """Whether this HAL is of this robot at all."""
    ours: Mapping[str, object] = {
        "id": robot_id,
        "robot hash": robot.robot_hash.hex()[:16],
        "period in ns": robot.tick_period_ns,
        "joints": list(robot.joint_names),
        "passive joints": list(robot.passive_joint_names),
        "parts": [(part.name, list(part.joints)) for part in robot.parts],
    }
    theirs: Mapping[str, object] = {
        "id": hal.robot,
        "robot hash": hal.robot_hash.hex()[:16],
        "period in ns": hal.period_ns,
        "joints": list(hal.joints),
        "passive joints": list(hal.passive_joints),
        "parts": [(part.name, list(part.joints)) for part in hal.parts],
    }
    wrong = [
        f"{what}: {theirs[what]}, declared {ours[what]}"
        for what in ours
        if ours[what] != theirs[what]
    ]
    count = f"{len(hal.joints)} joints and {len(hal.passive_joints)} passive"
    return DESCRIPTION.row(wrong, f"{count}, {len(hal.parts)} parts, as declared")


def modes_and_ranges(robot: RobotManifest, profile: str, hal: HalStatus) -> Iterator[Row]:
    """What the HAL says that each part can be told."""
    wrong_modes, wrong_ranges, count = list[str](), list[str](), 0
    for part in hal.parts:
        declared = set(robot.part(part.name).modes)
        told = {_mode_name(one.mode) for one in part.ranges}
        if told != declared:
            wrong_modes.append(f"{part.name}: {sorted(told)}, declared {sorted(declared)}")
        limits = robot.profile(profile).parts[part.name]
        for one in part.ranges:
            if _mode_name(one.mode) not in declared:
                continue
            ends = command_range(robot, robot.part(part.name), ControlMode(one.mode), limits)
            where = f"{part.name} {_mode_name(one.mode)}"
            wrong_ranges += _range_problems(where, (one.lower, one.upper), ends)
            count += 1
    yield MODES.row(wrong_modes, f"{count} modes, as declared")
    yield RANGES.row(wrong_ranges, f"{count} ranges")


def _mode_name(mode: int) -> str:
    try:
        return ControlMode(mode).yaml_name
    except ValueError:
        return f"mode {mode}"


def _range_problems(
    where: str, told: tuple[bytes, bytes], declared: tuple[FloatArray, FloatArray]
) -> list[str]:
    if any(len(one) != 8 * len(declared[0]) for one in told):
        return [f"{where}: {len(told[0]) / 8:g} values, expected {len(declared[0])}"]
    ends, limits = np.concatenate([floats(one) for one in told]), np.concatenate(declared)
    off = np.abs(ends) > RANGE_FACTOR * np.abs(limits) + TINY
    off |= np.abs(limits) > RANGE_FACTOR * np.abs(ends) + TINY
    if not off.any():
        return []
    at = int(np.argmax(off))
    return [f"{where}: {ends[at]:g}, declared {limits[at]:g}"]


def joint_states(stage: Stage) -> Row:
    """Of everything that was heard so far."""
    order = [one.tick for one in stage.states.every()]
    problems = list(stage.states.unfit)
    gaps = [f"tick {later} after tick {one}" for one, later in pairwise(order) if later != one + 1]
    return STATES.row(problems + gaps, f"{len(order)} states, ticks {order[0]} to {order[-1]}")


def si_positions(stage: Stage) -> Row:
    """Of everything that was heard so far."""
    robot, problems = stage.robot, list[str]()
    every = np.array([one.positions for one in stage.states.every()])
    for index, name in enumerate(robot.measured_joint_names):
        joint = robot.joint(name)
        if not joint.has_bounds:
            continue
        beyond = stage.profile.measured[name].tolerance or 0.0
        low, high = float(every[:, index].min()), float(every[:, index].max())
        if low < joint.lower - beyond or high > joint.upper + beyond:
            problems.append(
                f"{name}: {low:.4g} to {high:.4g} {joint.unit}, declared {joint.lower:g} to "
                f"{joint.upper:g} +- {beyond:g}"
            )
    return POSITIONS.row(problems, f"all, in {len(every)} states")


def turns(robot: RobotManifest, states: Sequence[Heard]) -> Iterator[Row]:
    """Of a robot that has continuous joints: whether one was seen to go on, or to jump."""
    every, unseen, problems = np.array([one.positions for one in states]), list[str](), list[str]()
    names = robot.measured_joint_names
    continuous = [name for name in names if robot.joint(name).type == "continuous"]
    for name in continuous:
        found = every[:, names.index(name)]
        jump = int(np.argmax(np.abs(np.diff(found, prepend=found[0]))))
        if abs(found[jump] - found[jump - 1]) > np.pi and jump:
            problems.append(f"{name}: {found[jump - 1]:.4g} rad, then {found[jump]:.4g} rad")
        if np.abs(found).max() <= np.pi:
            unseen.append(name)
    if continuous and unseen and not problems:
        far = "turn each beyond +-3.14 rad (fairlead jog) and look whether it goes on"
        yield TURNS.not_checked(f"{', '.join(unseen)}: stayed within half a turn; {far}")
    elif continuous:
        yield TURNS.row(problems, f"{len(continuous)} joints, beyond half a turn")


def ticking(stage: Stage, states: Sequence[Heard], control: Lateness) -> Iterator[Row]:
    """Rate and jitter over states in a row, with the control's lateness beside them."""
    period_ms = stage.period_s * 1e3
    rate = f"a tick every {period_ms:g} ms +- {100 * RATE_SHARE:g} %"
    jitter = f"{JITTER_PERCENTILE:g} % of ticks within {JITTER_SHARE * period_ms:.3g} ms of that"
    rate_check, jitter_check = (_with(RATE, rate), _with(JITTER, jitter))
    if stage.lockstep:
        why = "a world in lockstep waits for each decision"
        yield from (rate_check.not_checked(why), jitter_check.not_checked(why))
        return
    gaps_ms = np.diff([one.came_ns for one in states]) / 1e6
    mean, off = float(gaps_ms.mean()), np.abs(gaps_ms - period_ms)
    worst = float(np.percentile(off, JITTER_PERCENTILE))
    late_ms, worst_late_ms = 1e3 * control.mean_s, 1e3 * control.percentile_s
    beside = f"control: a sleeper woke {late_ms:.2f} ms late, {worst_late_ms:.2f} ms at worst"
    got = f"{mean:.2f} ms over {len(gaps_ms)} ticks; {beside}"
    bound = RATE_SHARE * period_ms
    is_off = not -bound <= mean - period_ms <= bound + late_ms
    yield rate_check.row([got] if is_off else [], got)
    got = f"{worst:.2f} ms, at most {off.max():.2f} ms; {beside}"
    is_off = worst > JITTER_SHARE * period_ms + worst_late_ms
    yield jitter_check.row([got] if is_off else [], got)


def _with(check: Check, expected: str) -> Check:
    return Check(check.name, expected, check.source, check.fix)
