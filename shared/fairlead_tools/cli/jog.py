"""``fairlead jog`` and ``home``: a way that ends by itself; and what all drives by hand share."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Annotated

import numpy as np
import typer

from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError, ServiceError, expected
from fairlead.messages import FloatArray
from fairlead.operate.client import RobotClient
from fairlead.operate.rows import check_offered, offered_modes
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_tools.cli.arming import YesOption, armed
from fairlead_tools.cli.console import ProgressLine, echo, ends_like_ctrl_c
from fairlead_tools.cli.options import (
    DeploymentOption,
    choose_deployment,
    example,
)
from fairlead_tools.teleop.device import InputDevice
from fairlead_tools.teleop.drive import Drive, make_drive
from fairlead_tools.teleop.grip import Grip, gripper_beside
from fairlead_tools.teleop.session import At, HandDriving, State
from fairlead_tools.teleop.takeover import taken
from fairlead_tools.teleop.target import BaseWay, Target, ToolWay, tolerance

PartOption = Annotated[
    str, typer.Option(help="what is driven; default: the first part that can be")
]
SpeedOption = Annotated[
    float, typer.Option(min=0.02, max=1.0, help="share of the full speed by hand")
]
_AMOUNT = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*([a-z]*)$", re.I)
_UNITS = {"m": {"": 1.0, "m": 1.0, "mm": 1e-3, "cm": 1e-2},
          "rad": {"": 1.0, "rad": 1.0, "deg": np.pi / 180}}  # fmt: skip
_MOST = {"m": 10.0, "rad": 2 * np.pi}


class Hand:
    """A robot, one drive of it and its open client: what all three commands have."""

    def __init__(
        self, client: RobotClient, robot: RobotManifest, drive: Drive, task: str = ""
    ) -> None:
        self.client, self.robot, self.drive, self.task = client, robot, drive, task
        self.limits = robot.profile(client.deployment.profile)
        self.gripper = gripper_beside(robot, drive.part)
        self.parts = (drive.part, self.gripper) if self.gripper else (drive.part,)
        self.lockstep = client.hal_status().pacing == "lockstep"

    def driving(self, device: InputDevice, at: At | None = None) -> HandDriving:
        """The loop for a device; with ``at`` for one that is no person."""
        grip = Grip(self.robot, self.limits, self.gripper) if self.gripper else None
        return HandDriving(
            self.robot,
            self.drive,
            grip,
            device,
            lockstep=self.lockstep,
            horizon=self.limits.protocol.horizon_max,
            at=at,
            paced=not isinstance(device, Target),
        )


def require_offered(drive: Drive, client: RobotClient) -> None:
    """Raises `ConfigError` before anything is armed: a HAL stops at a mode that it cannot do."""
    check_offered(drive.part, drive.mode, offered_modes(client.hal_status()))


def shown(drive: Drive, line: ProgressLine) -> Callable[[State], None]:
    """Show what becomes of each tick; each new refusal or note on a line of its own."""
    said = ""

    def show(now: State) -> None:
        nonlocal said
        if now.asked.note and now.asked.note != said:
            line.say(now.asked.note)
        said = now.asked.note
        if now.news:
            line.say(f"refused: {now.news}")
        clutch = "clutch in" if now.asked.clutch else "clutch out, holding"
        moves = ", moving" if now.is_moving else ""
        back = f" | refused: {now.held_back}" if now.held_back else ""
        line.show(
            f"tick {now.tick:5d} | {drive.part} {drive.mode.yaml_name} | {clutch}{moves} | "
            f"speed {now.asked.speed:.0%}{back}"
        )

    return show


def parse_amount(text: str, axis: str, unit: str) -> float:
    """How far to jog, in m or rad: a number, with its unit or in SI.

    Raises:
        ConfigError: it is no number, has another unit, or is more than 10 m or a turn.
    """
    found = _AMOUNT.match(text)
    factors = _UNITS[unit]
    valid = [name for name in factors if name]
    if found is None or found.group(2) not in factors:
        raise ConfigError(expected("jog", f"a way for {axis}, as 0.05 [{unit}]", repr(text), valid))
    amount = float(found.group(1)) * factors[found.group(2)]
    if abs(amount) > _MOST[unit]:
        most = f"a way of at most {_MOST[unit]:.4g} {unit}"
        if found.group(2):
            raise ConfigError(expected("jog", most, repr(text)))
        raise ConfigError(expected("jog", most, f"{text!r} [{unit}]", valid))
    return amount


@example("fairlead jog panda_joint1 -10deg", negative=True)
def jog_command(
    axis: Annotated[
        str,
        typer.Argument(
            metavar="JOINT|AXIS", help="a joint; or x, y, z, rx, ry, rz of a tool or a base"
        ),
    ],
    amount: Annotated[
        str,
        typer.Argument(
            help="how far from where it is: 0.05, 50mm, -0.2rad, 10deg; a tool comes within 2 mm "
            "or 5 mrad of it, a base within 20 mm or 20 mrad"
        ),
    ],
    part: PartOption = "",
    speed: SpeedOption = 0.3,
    deployment: DeploymentOption = None,
    yes: YesOption = False,
) -> None:
    """Move one joint, or a tool or base along one axis, by an amount; then hold.

    A tool moves along the axes of the first frame its deltas are given in, a base along its own.
    """
    chosen, amount = choose_deployment(deployment), amount.strip()
    robot = load_robot(chosen.robot)
    drive = _drive_along(axis, robot, chosen.profile, part)
    index = drive.index(axis)
    unit = drive.units[index]
    step = np.zeros(len(drive.names))
    step[index] = parse_amount(amount, axis, unit)
    near = float(tolerance(drive)[index])
    if abs(step[index]) <= near:
        wanted = f"more than {near:g} {unit}, as near as {drive.mode.yaml_name} comes"
        raise ConfigError(expected(f"jog {axis}", wanted, repr(amount)))
    if drive.tool and not drive.is_position and unit == "rad" and abs(step[index]) >= math.pi:
        raise ConfigError(expected(f"jog {axis}", "less than half a turn of a tool", repr(amount)))
    with _hand(chosen, robot, drive, yes, "jog") as hand:
        first, last = _go(hand, lambda at: at + step, speed, index)
    came = f"{axis} moved {(last - first)[index]:.4f} {unit}"
    if not drive.is_position:
        came += f" of {step[index]:.4f} {unit}: {drive.mode.yaml_name} comes within {near:g} {unit}"
    echo(came)


def _drive_along(axis: str, robot: RobotManifest, profile: str, part: str) -> Drive:
    """As `make_drive`; of what another part has, or is, it says how to drive that one."""
    try:
        return make_drive(robot, profile, part, axis=axis)
    except ConfigError as error:
        owners = [one.name for one in robot.parts if axis in (one.name, *one.joints)]
        if not owners or owners[0] == part:
            raise
        axes = ", ".join(make_drive(robot, profile, owners[0]).names)
        whose = f"{axis} is of part {owners[0]}, which moves along {axes}: --part {owners[0]}"
        raise ConfigError(f"{error}; {whose}") from None


@example("fairlead home")
def home_command(
    part: Annotated[
        str, typer.Option(help="default: every part whose joints are told positions")
    ] = "",
    speed: SpeedOption = 0.3,
    deployment: DeploymentOption = None,
    yes: YesOption = False,
) -> None:
    """Move joints straight to where robot.yaml says the robot rests; one part after the other.

    The straight way may cross what is around the robot: the gate refuses what it knows of.
    A joint that turns on has no home in robot.yaml: it stays where it is, and is named.
    """
    chosen = choose_deployment(deployment)
    robot = load_robot(chosen.robot)
    if robot.home is None:
        raise ConfigError(f"robot {robot.id}: robot.yaml has no `home`; say there where it rests")
    position, limits = "joint_position", robot.profile(chosen.profile)
    able = [one.name for one in robot.parts if position in limits.parts[one.name].names]
    drives = [
        make_drive(robot, chosen.profile, name, position) for name in ([part] if part else able)
    ]
    if not drives:
        raise ConfigError(
            f"robot {robot.id}: no part is told {position}, so joints cannot go home; a skill can: "
            "fairlead skill ls"
        )
    for drive in drives:
        rests = [robot.home.positions.get(name, np.nan) for name in drive.names]
        with _hand(chosen, robot, drive, yes, "home") as hand:
            _go(hand, partial(_or_there, np.array(rests)), speed)
        echo(_came_home(drive, rests))


def _came_home(drive: Drive, rests: Sequence[float]) -> str:
    staying = [name for name, rest in zip(drive.names, rests, strict=True) if np.isnan(rest)]
    if not staying:
        return f"{drive.part} is home"
    names = ", ".join(staying)
    return f"{drive.part} is home but for {names}: without a home in robot.yaml, left where it was"


def _or_there(rests: FloatArray, at: FloatArray) -> FloatArray:
    """A joint that has no place to rest, for it turns on, stays."""
    return np.where(np.isnan(rests), at, rests)


@contextmanager
def _hand(
    deployment: Deployment, robot: RobotManifest, drive: Drive, yes: bool, task: str
) -> Iterator[Hand]:
    with ends_like_ctrl_c(), RobotClient(deployment, by=f"fairlead {task}") as client:
        require_offered(drive, client)
        with armed(client, confirmed=yes):
            yield Hand(client, robot, drive, task)


def _go(
    hand: Hand, wanted: Callable[[FloatArray], FloatArray], speed: float, axis: int | None = None
) -> tuple[FloatArray, FloatArray]:
    """Where the axes were at the start and at the end [rad or m].

    Raises:
        ServiceError: it came no nearer, with the refusal if there was one.
    """
    drive, seen = hand.drive, list[State]()
    target = Target(drive, wanted, tolerance(drive, axis), speed)
    at: At | None = None
    if drive.tool and not drive.is_position:
        at = ToolWay(drive, hand.client.transforms())
    elif not drive.is_position:
        at = BaseWay(drive, hand.robot.base_frame)
    with (
        ProgressLine() as line,
        taken(hand.client, (drive.part,), hand.task, hand.task) as claim,
    ):
        on_line = shown(drive, line)

        def show(now: State) -> None:
            on_line(now)
            if np.isfinite(now.at).all():
                seen.append(now)

        hand.driving(target, at).run(claim, show)
    if target.is_there:
        return seen[0].at, seen[-1].at
    why = next((now.held_back for now in reversed(seen) if now.held_back), "")
    where = _where(drive, wanted, seen) if seen else "nobody sends its transform"
    raise ServiceError(
        f"{drive.part} came no nearer and holds; {where}" + (f"; {why}" if why else "")
    )


def _where(drive: Drive, wanted: Callable[[FloatArray], FloatArray], seen: Sequence[State]) -> str:
    """Where its joints are, and which end kept one; else how far a tool or base has come."""
    found = ", ".join(
        f"{name} {value:.4f} {unit}"
        for name, value, unit in zip(drive.names, seen[-1].at, drive.units, strict=True)
    )
    if not drive.is_position:
        return f"it has moved by {found}"
    goal = wanted(seen[0].at)
    ends = [
        f"; {name} ends at {end:.4f} {unit}"
        for name, unit, to, lower, upper in zip(
            drive.names, drive.units, goal, drive.lower, drive.upper, strict=True
        )
        if (end := float(np.clip(to, lower, upper))) != to
    ]
    return f"it is at {found}{''.join(ends)}"
