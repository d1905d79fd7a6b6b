"""``fairlead teleop``: a person drives, alone or in turns with a policy."""

from __future__ import annotations

from typing import Annotated

import typer

from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError, ServiceError, expected
from fairlead.operate.client import RobotClient
from fairlead.operate.goal_run import GoalOptions
from fairlead.operate.runner_choice import choose_runner
from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.arming import YesOption, armed
from fairlead_tools.cli.console import ProgressLine, ends_like_ctrl_c
from fairlead_tools.cli.jog import Hand, PartOption, SpeedOption, require_offered, shown
from fairlead_tools.cli.options import DeploymentOption, choose_deployment, example
from fairlead_tools.cli.skill import installed_skill
from fairlead_tools.teleop.device import InputDevice
from fairlead_tools.teleop.drive import Drive, make_drive
from fairlead_tools.teleop.gamepad import Gamepad, open_gamepad
from fairlead_tools.teleop.keyboard import Keyboard, Keys
from fairlead_tools.teleop.leader import MODEL as LEADER
from fairlead_tools.teleop.leader import LeaderArm, open_leader
from fairlead_tools.teleop.takeover import taken, watch_policy


@example("fairlead teleop --speed 0.3")
def teleop_command(
    part: PartOption = "",
    mode: Annotated[
        str,
        typer.Option(help="joint_position, cartesian_delta, body_twist; default: its first"),
    ] = "",
    device: Annotated[
        str,
        typer.Option(
            help="keyboard, gamepad, a gamepad's path such as /dev/input/event3, or so101: a "
            "leader arm"
        ),
    ] = "keyboard",
    port: Annotated[str, typer.Option(help="with --device so101: the leader's serial port")] = "",
    calibration: Annotated[
        str,
        typer.Option(help="with --device so101: of fairlead calibrate so101 --arm leader"),
    ] = "so101_leader",
    over: Annotated[
        str,
        typer.Option(
            metavar="SKILL", help="run this skill, and take its parts over with the clutch"
        ),
    ] = "",
    prompt: Annotated[str, typer.Option(help="with --over: the skill's instruction")] = "",
    speed: SpeedOption = 0.3,
    deployment: DeploymentOption = None,
    yes: YesOption = False,
) -> None:
    """Drive a part by hand, through the gate; nothing moves without the clutch.

    It arms if disarmed. Ctrl-C, a closed terminal or a lost keyboard give the parts back: they
    hold. With --over the clutch ends the skill's goal and the person has its parts; giving them
    back starts the goal anew from where the robot is.
    """
    chosen = choose_deployment(deployment)
    robot = load_robot(chosen.robot)
    drive = make_drive(robot, chosen.profile, part, mode)
    wish = _goal(chosen, over, prompt) if over else None
    opened: Keyboard | Gamepad | LeaderArm
    if port and device != LEADER:
        raise ConfigError(expected("teleop: --port", f"--device {LEADER} with it", repr(device)))
    if device == LEADER:
        opened = open_leader(robot, drive, port, calibration, speed)
    else:
        opened = _device(device, drive, speed)
    with (
        ends_like_ctrl_c(),
        ProgressLine() as line,
        RobotClient(chosen, by="fairlead teleop") as client,
    ):
        require_offered(drive, client)
        with armed(client, confirmed=yes), opened:
            line.say(opened.help)
            _take_turns(Hand(client, robot, drive), opened, wish, line)


def _device(name: str, drive: Drive, speed: float) -> Keyboard | Gamepad:
    if name == "keyboard":
        return Keyboard(Keys(drive.names, speed))
    if name != "gamepad" and not name.startswith("/dev/"):
        what = "keyboard, gamepad, a gamepad's path such as /dev/input/event3, or so101"
        raise ConfigError(expected("teleop", what, repr(name)))
    return open_gamepad(drive.names, speed, "" if name == "gamepad" else name)


def _goal(deployment: Deployment, skill: str, prompt: str) -> GoalOptions:
    name = installed_skill(skill)
    return GoalOptions(name, prompt, runner=choose_runner(deployment, name, ""))


def _take_turns(
    hand: Hand, device: InputDevice, wish: GoalOptions | None, line: ProgressLine
) -> None:
    while True:
        parts: tuple[str, ...] = ()
        if wish is not None:
            line.say(f"{wish.skill} drives; the clutch takes its parts over")
            ended = watch_policy(hand.client, wish, device, lambda now: line.show(now.line()))
            if not isinstance(ended, tuple):
                if ended.outcome not in ("succeeded", "cancelled"):
                    told = f"{wish.skill} {ended.outcome}: {ended.detail or ended.kind}"
                    raise ServiceError(f"teleop: {told}")
                line.say(f"{wish.skill} {ended.outcome} {ended.detail}".rstrip())
                return
            parts = ended
        task = f"teleop over {wish.skill}" if wish is not None else "teleop"
        wanted = tuple(dict.fromkeys((*hand.parts, *parts)))
        with taken(hand.client, wanted, task) as claim:
            line.say(f"you drive {', '.join(wanted)}")
            ended_by = hand.driving(device).run(claim, shown(hand.drive, line))
        line.say(f"{', '.join(wanted)} given back")
        if wish is None or ended_by == "quit":
            return
