"""``fairlead robot new``, ``check`` and ``measure``: the way of a robot that is new here."""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
import yaml

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError, expected
from fairlead.keys import check_name
from fairlead.messages import HalStatus
from fairlead.operate.client import RobotClient
from fairlead.operate.connection import connect
from fairlead.robot.home_check import singular_homes
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_tools.cli.arming import YesOption, armed
from fairlead_tools.cli.console import ProgressLine, echo, ends_like_ctrl_c, print_json, print_table
from fairlead_tools.cli.options import (
    JsonOption,
    RobotArgument,
    deployment_option,
    example,
)
from fairlead_tools.cli.running_deployments import running_file

if TYPE_CHECKING:
    from fairlead_tools.draft.robot_check import FrameRow
    from fairlead_tools.measure.measurement import Measurement


@example("fairlead robot new my_arm --mjcf my_arm.xml")
def new_command(
    name: Annotated[str, typer.Argument(metavar="ID", help="the robot's id, and its folder")],
    mjcf: Annotated[
        Path | None, typer.Option(help="its MuJoCo model, for geometry and servos")
    ] = None,
    urdf: Annotated[
        Path | None,
        typer.Option(help="its description, with speeds and efforts; else made of the MJCF"),
    ] = None,
) -> None:
    """Draft a robot from its files: limits, capsules, home, URDF, and a deployment file here.

    The folder goes to $FAIRLEAD_ROBOTS, else ~/.local/share/fairlead/robots. What no file says is
    assumed and listed in robot.yaml, to_confirm: the profile hardware is refused until a person
    has gone through it.
    """
    from fairlead_tools.draft.file_text import deployment_text
    from fairlead_tools.draft.new_robot import Asked, new_robot

    check_name("robot new: id", name)
    file = Path(f"{name}.yaml")
    if file.exists():
        raise ConfigError(f"robot new: {file} exists already; move it, or choose another id")
    with ends_like_ctrl_c(), ProgressLine() as line, line.counting() as say:
        drafted = new_robot(Asked(name, mjcf, urdf), say)
    try:
        file.write_text(deployment_text(name, drafted.hal, drafted.missing), encoding="utf-8")
    except OSError as error:
        shutil.rmtree(drafted.folder)
        raise ConfigError(f"robot new: cannot write {file.absolute()}: {error.strerror}") from None
    robot = drafted.robot
    parts = "; ".join(f"{part.name}: {', '.join(part.joints)}" for part in robot.parts)
    echo(f"wrote {drafted.folder} and {file}\n{parts}")
    echo(
        f"{len(robot.to_confirm)} entries of robot.yaml are to be given or confirmed before "
        "hardware: to_confirm"
    )
    for found in singular_homes(robot).values():
        echo(found)
    if drafted.missing:
        first, *more = drafted.missing
        echo(f"hal_mujoco cannot move it yet: {first}")
        if more:
            echo(f"  and {len(more)} more: fairlead robot check {name}")
        echo(f"{file} runs {drafted.hal}, without physics or true tool motions, until then")
    echo(f"next: fairlead robot check {name}; fairlead up {file}")


@example("fairlead robot check panda")
def check_command(
    robot: RobotArgument,
    deployment: Annotated[
        Path | None,
        deployment_option(
            "--deployment",
            "-d",
            what="whose HAL to compare with: ",
            without="the one that runs here, if any",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Compare a robot's URDF, MJCF, capsules, gate files and HAL; what is missing, each with a fix.

    Exit code 1 if anything is missing or wrong; what is open is for a person to look at.
    """
    manifest = load_robot(robot)
    file = deployment or running_file(robot)
    hal = None if file is None else _running_hal(manifest, file)
    from fairlead_tools.draft.robot_check import check_robot

    found = check_robot(manifest, hal)
    if as_json:
        document = dataclasses.asdict(found) | {"to_confirm": manifest.to_confirm}
        print_json({"robot": robot, "good": found.is_good, **document})
    else:
        if found.frames:
            _print_frames(found.frames)
        print_table(
            ("WHAT", "STATE", "FOUND", "FIX"),
            [(one.subject, one.state, _first_line(one.found), one.fix) for one in found.findings],
        )
    if not found.is_good:
        raise typer.Exit(1)


def _print_frames(frames: Sequence[FrameRow]) -> None:
    print_table(
        ("FRAME", "AT HOME [mm]", "[rad]", "RANDOM POSES [mm]", "[rad]"),
        [
            (one.frame, f"{one.home_mm:.3g}", f"{one.home_rad:.2g}",
             f"{one.random_mm:.3g}", f"{one.random_rad:.2g}")
            for one in frames
        ],
    )  # fmt: skip
    echo("")


def _first_line(text: str) -> str:
    first, *more = text.splitlines()
    return f"{first} ... (--json has all)" if more else first


def _running_hal(robot: RobotManifest, file: Path) -> HalStatus:
    deployment = load_deployment(file)
    if deployment.robot != robot.id:
        what = f"a deployment of {robot.id}"
        raise ConfigError(expected("robot check", what, f"one of {deployment.robot}"))
    with RobotClient(deployment) as client:
        return client.hal_status()


@example("fairlead robot measure panda")
def measure_command(
    robot: RobotArgument,
    deployment: Annotated[
        Path | None,
        deployment_option(
            "--deployment",
            "-d",
            what="whose HAL to drive: ",
            without="with --running the one that runs here, else ROBOT.yaml here, else the robot's "
            "first in lockstep",
        ),
    ] = None,
    random: Annotated[
        int, typer.Option(min=80, help="ticks of each random drive of a simulator")
    ] = 800,
    stops: Annotated[int, typer.Option(min=1, help="drives that end in a stop")] = 18,
    running: Annotated[
        bool, typer.Option("--running", help="a robot that is up: slowly, through its gate")
    ] = False,
    share: Annotated[
        float, typer.Option(min=0.01, max=1.0, help="of full scale, with --running")
    ] = 0.1,
    yes: YesOption = False,
    as_json: JsonOption = False,
) -> None:
    """Drive a robot and print its gains, tracking, stops, efforts and dead bands as limits.

    A simulator is driven by itself at full scale, without gate and services: each axis, at random,
    all parts together, to a stop. A robot (--running) has to be up, in realtime: each axis moves
    alone, slowly, through its gate; with profile hardware it asks first, or wants --yes. What is
    printed comes with the margin it says; write it into robot.yaml.
    """
    from fairlead_tools.measure.driven_robot import DrivenRobot, simulated_deployment
    from fairlead_tools.measure.measurement import Amount, measure

    manifest = load_robot(robot)
    file = deployment or (running_file(robot) if running else _file_here(robot))
    chosen = load_deployment(file) if file else simulated_deployment(robot)
    if chosen.robot != robot:
        who = f"robot measure: deployment {chosen.id}"
        raise ConfigError(expected(who, f"robot {robot}", chosen.robot))
    if not running and not manifest.profile(chosen.profile).lockstep_allowed:
        who, what = f"robot measure: deployment {chosen.id}", "--running, for it is no simulator"
        raise ConfigError(expected(who, what, f"profile {chosen.profile}"))
    with ProgressLine(quiet=as_json) as line:
        line.show(f"{robot}: {chosen.services[chosen.hal].run or chosen.hal} starts")
        if running:
            found = _measured_running(robot, chosen, share, yes, line.show)
        else:
            found = measure(DrivenRobot(robot, chosen), Amount(random, stops), line.show)
    if as_json:
        from fairlead_tools.measure.report import document

        print_json(document(found))
    else:
        _print_measured(found)


def _file_here(robot: str) -> Path | None:
    """Where `fairlead robot new` put it."""
    file = Path(f"{robot}.yaml")
    return file if file.is_file() else None


def _measured_running(
    robot: str, deployment: Deployment, share: float, yes: bool, say: Callable[[str], None]
) -> Measurement:
    """Through the gate of a deployment that is up, all parts claimed; disarmed afterwards."""
    from fairlead_tools.measure.driven_robot import DrivenRobot
    from fairlead_tools.measure.measurement import measure_gently
    from fairlead_tools.measure.through_gate import ThroughGate

    manifest = load_robot(robot)
    with (
        ends_like_ctrl_c(),
        connect(deployment, by="fairlead robot measure") as client,
        armed(client, yes),
        client.claim(manifest.part_names, source="measure") as claim,
    ):
        backend = ThroughGate(client, manifest, claim)
        found = measure_gently(DrivenRobot(robot, deployment, backend), share, say)
    if backend.refused:
        say(f"the gate refused {backend.refused} rows, and the robot held; see: fairlead why")
    return found


def _print_measured(found: Measurement) -> None:
    from fairlead_tools.measure.report import document

    told = document(found)
    ticks = sum(told["ticks"].values())
    echo(f"{told['robot']}, {told['hal']}, profile {told['profile']}: {ticks} ticks\n")
    print_table(
        ("JOINT", "TOLD", "SPEED", "EFFORT", "IN CONTACT", "JUMP", "BEYOND", "AT REST", "DEAD BAND",
         "STOP [s]"),
        [_joint_row(row) for row in told["joints"].values()],
    )  # fmt: skip
    echo("speeds in rad/s or m/s, efforts in N m or N, jump, rest and dead band per tick\n")
    print_table(
        ("PART", "MODE", "OF", "GAIN", "BESIDE IT", "LAG"),
        [
            (row["part"], row["mode"], row["what"], _pair(row.get("gain")),
             _text(row.get("residual")), _text(row.get("lag")))
            for row in told["modes"]
        ],
    )  # fmt: skip
    echo("")
    for finding in told["findings"]:
        echo(f"look: {finding}")
    echo(f"\nfor safety.{told['profile']} of robot.yaml:\n")
    echo(
        yaml.safe_dump(
            told["proposed"], sort_keys=False, default_flow_style=None, width=96
        ).rstrip()
    )


def _joint_row(row: dict[str, Any]) -> tuple[str, ...]:
    names = ("told_per_s", "speed_per_s", "effort_free", "effort_touching", "jump_per_tick",
             "beyond", "change_at_rest", "dead_band", "stop_s")  # fmt: skip
    return (row["joint"], *(_text(row[name]) for name in names))


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:g}"


def _pair(gain: list[float] | None) -> str:
    return "-" if gain is None else f"{gain[0]:g} to {gain[1]:g}"
