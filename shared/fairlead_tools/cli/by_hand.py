"""What commands that move a robot by hand share: its parts, the line they show, how they end."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Annotated

import typer

from fairlead.operate.client import RobotClient
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.cli.console import ProgressLine
from fairlead_tools.teleop.device import InputDevice
from fairlead_tools.teleop.drive import Drive
from fairlead_tools.teleop.grip import Grip, gripper_beside
from fairlead_tools.teleop.session import At, HandDriving, State
from fairlead_tools.teleop.target import Target

PartOption = Annotated[
    str, typer.Option(help="what is driven; default: the first part that can be")
]
SpeedOption = Annotated[
    float, typer.Option(min=0.02, max=1.0, help="share of the full speed by hand")
]


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


@contextmanager
def ends_like_ctrl_c() -> Iterator[None]:
    """A closed terminal and SIGTERM end the block as Ctrl-C does: what was begun is undone."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        signal.raise_signal(signal.SIGINT)

    before = {one: signal.signal(one, interrupt) for one in (signal.SIGHUP, signal.SIGTERM)}
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
