"""``fairlead hal``: does a running HAL keep the contract?"""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.registry import Registry
from fairlead.errors import ConfigError, RefusedError, expected
from fairlead.hal.serve import hal_driver
from fairlead.operate.connection import choose_file
from fairlead.plugins import HALS
from fairlead.robot.manifest import load_robot
from fairlead.wire.session import ZenohBus
from fairlead_tools.cli.console import ProgressLine, echo, ends_like_ctrl_c, print_json, print_table
from fairlead_tools.cli.options import (
    JsonOption,
    deployment_option,
    example,
    make_group,
)
from fairlead_tools.conformance.row import GROUPS

if TYPE_CHECKING:
    from fairlead_tools.conformance.hal_check import HalCheck


SIMULATOR_SHARE = 0.3
ROBOT_SHARE = 0.1


@example("fairlead hal check so101_mujoco")
def check_command(
    target: Annotated[Path | None, deployment_option(what="whose HAL: ")] = None,
    share: Annotated[
        float | None,
        typer.Option(min=0.01, max=1.0, help="of full scale; default 0.3, of a real robot 0.1"),
    ] = None,
    hold_s: Annotated[
        float, typer.Option(min=0.5, max=3600.0, help="how long a hold is watched for drift")
    ] = 3.0,
    pid: Annotated[
        int | None, typer.Option(min=2, help="of the HAL's process, if `fairlead ps` has none")
    ] = None,
    only: Annotated[
        list[str] | None,
        typer.Option(help=f"of the checks after holding: {', '.join(GROUPS)}; repeatable"),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="move a real robot without asking")] = False,
    as_json: JsonOption = False,
) -> None:
    """Check a running HAL against its contract and its robot's file; exit code 1 if it fails any.

    It takes the gate's place, so start the services without it: fairlead up NAME --without safety.
    No gate judges its rows: each joint, tool and base moves a little to and fro, at small shares of
    its limits. It asks first, or wants --yes, unless the HAL is a simulator's. It ends held.
    """
    for one in only or ():
        if one not in GROUPS:
            raise ConfigError(expected("hal check: --only", "a group", repr(one), GROUPS))
    deployment = load_deployment(choose_file(target))
    simulator = is_simulator(deployment)
    from fairlead_tools.conformance.hal_check import CheckOptions, ask_hal, check_hal

    hal = ask_hal(deployment)
    bus = ZenohBus(deployment.tool_endpoints(deployment.only("safety")))
    try:
        amount = share or (SIMULATOR_SHARE if simulator else ROBOT_SHARE)
        if not simulator:
            _ask(deployment, amount, yes)
        known, why = (pid, "") if pid else _pid(deployment)
        with ends_like_ctrl_c(), ProgressLine(quiet=as_json) as line:
            wish = CheckOptions(amount, hold_s, known, why, simulator, tuple(only or ()))
            found = check_hal(bus, deployment, hal, wish, line.show)
    finally:
        bus.close()
    document = _document(deployment, found)
    if as_json:
        print_json(document)
    else:
        _print(document)
    if not found.is_good:
        raise typer.Exit(1)


def _document(deployment: Deployment, found: HalCheck) -> dict[str, Any]:
    return {
        "robot": deployment.robot,
        "deployment": deployment.id,
        "hal": deployment.services[deployment.hal].what,
        "pacing": found.hal.pacing,
        "profile": deployment.profile,
        "good": found.is_good,
        "rows": [dataclasses.asdict(row) for row in found.rows],
    }


def is_simulator(deployment: Deployment) -> bool:
    """Whether nothing real can move: only where the HAL's driver says so, and limits for that."""
    profile = load_robot(deployment.robot).profile(deployment.profile)
    run = deployment.services[deployment.hal].run
    if not profile.lockstep_allowed or run not in HALS.names():
        return False
    return hal_driver(run, "hal check").simulator


def _ask(deployment: Deployment, share: float, yes: bool) -> None:
    if yes:
        return
    if not sys.stdin.isatty():
        reason = "this HAL is no simulator's: the robot will move, and no gate judges how"
        raise RefusedError("hal check", reason, "add --yes, if people and things keep clear of it")
    from fairlead_tools.conformance.small_rows import SmallRows

    robot = load_robot(deployment.robot)
    modes = {part.name: part.control_modes for part in robot.parts}
    worst = SmallRows(robot, deployment.profile, share, modes).worst()
    typer.confirm(
        f"The HAL of {robot.id} is no simulator's. Every joint will move, all of a part at once, "
        f"{worst}, and no gate judges how: keep people and things clear, and the emergency stop "
        "at hand. Go on?",
        abort=True,
        err=True,
    )


def _pid(deployment: Deployment) -> tuple[int | None, str]:
    """The HAL's process on this machine, or why it is not known."""
    for entry in Registry().entries():
        if load_deployment(Path(entry.deployment)).keys == deployment.keys:
            service = entry.services.get(deployment.hal)
            if service is not None and service.running is not None:
                return service.running.pid, ""
    return None, "its process is not in `fairlead ps`, or on another host; give --pid"


def _print(document: dict[str, Any]) -> None:
    rows = document["rows"]
    echo(
        f"{document['robot']}, {document['hal']}, profile {document['profile']}, "
        f"{document['pacing']}\n"
    )
    print_table(
        ("CHECK", "OF", "RESULT", "EXPECTED", "GOT"),
        [(r["check"], r["of"], r["outcome"], r["expected"], r["got"]) for r in rows],
    )
    failed = [row for row in rows if row["outcome"] == "fail"]
    left = sum(row["outcome"] == "not checked" for row in rows)
    echo("")
    for row in failed:
        echo(f"FAILED {row['check']} {row['of']}".rstrip() + f": {row['got']}")
        echo(f"  expected by {row['source']}; fix: {row['fix']}")
    echo(f"{len(rows) - len(failed) - left} passed, {len(failed)} failed, {left} not checked")


group = make_group(
    "hal", "Check a HAL: the driver of a robot or a simulator.", {"check": check_command}
)
