"""``fairlead topic``: look on at what the services publish."""

from __future__ import annotations

import asyncio
import itertools
import json
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from enum import IntEnum
from typing import Annotated, Any

import msgspec
import typer
import yaml

from fairlead.deploy.deployment import Deployment
from fairlead.errors import NoAnswerError
from fairlead.messages import Decision, GateState, Hold, JointState, Message, Outcome, floats
from fairlead.modes import ControlMode
from fairlead.operate.client import RobotClient
from fairlead.operate.connection import connect
from fairlead.operate.subscription import Heard, Subscription
from fairlead.wire.topics import find_topic, short_key, topics
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.options import (
    DeploymentOption,
    JsonOption,
    choose_deployment,
    example,
    make_group,
)

MAX_WAIT_S = 86_400.0

KeyArgument = Annotated[
    str, typer.Argument(help="key as in `fairlead topic list`; * stands for any name")
]
TimeoutOption = Annotated[
    float,
    typer.Option(min=0.1, max=MAX_WAIT_S, help="seconds without a message before it gives up"),
]


@example("fairlead topic list --seconds 2")
def list_command(
    deployment: DeploymentOption = None,
    seconds: Annotated[
        float, typer.Option(min=0.1, max=MAX_WAIT_S, help="how long to listen")
    ] = 2.0,
    as_json: JsonOption = False,
) -> None:
    """List a running robot's keys, their message types and how many messages came."""
    chosen = choose_deployment(deployment)
    known = topics(chosen.keys)
    counted = asyncio.run(_count(chosen, seconds))
    rows = []
    for topic in known:
        keys = sorted(key for key in counted if topic.matches(key)) or [topic.key_expr]
        rows += [
            (short_key(chosen.keys, key), topic.kind.__name__, counted.get(key, 0)) for key in keys
        ]
    if as_json:
        print_json([{"key": key, "type": kind, "messages": count} for key, kind, count in rows])
        return
    print_table(("KEY", "TYPE", f"IN {seconds:g} S"), [(k, t, n or "-") for k, t, n in rows])


async def _count(deployment: Deployment, duration_s: float) -> Counter[str]:
    """Messages of every key that come while one listens."""
    counted: Counter[str] = Counter()

    async def count(subscription: Subscription[Heard]) -> None:
        async for heard in subscription:
            counted[heard.key] += 1

    async with connect(deployment) as robot:
        await robot.wait_anyone()
        names = [topic.key_expr for topic in topics(deployment.keys)]
        subscriptions = [robot.topic(name, timeout_s=MAX_WAIT_S) for name in names]
        with suppress(TimeoutError):
            async with asyncio.timeout(duration_s), asyncio.TaskGroup() as counting:
                for subscription in subscriptions:
                    counting.create_task(count(subscription))
    return counted


_IDS = frozenset(
    ("session", "epoch", "claim_id", "verdict_id", "latch_id", "stop_id", "goal_id", "stop_ids")
)
_NAMED: dict[str, type[IntEnum]] = {
    "hold": Hold,
    "mode": ControlMode,
    "decision": Decision,
    "outcome": Outcome,
    "state": GateState,
}
# A picture's bytes are no numbers to read.
_OPAQUE = frozenset(("data",))
_HEX = frozenset(("robot_hash", "config_hash", "skill_hash", "trace"))


def message_document(message: Message) -> dict[str, Any]:
    """One message as plain JSON values, fields in wire order, without its version.

    Blocks of float64 become lists of numbers; a picture's bytes only their count.
    """
    return _struct(message)


def _struct(value: msgspec.Struct) -> dict[str, Any]:
    names = (field.name for field in msgspec.structs.fields(value))
    return {name: _field(name, getattr(value, name)) for name in names if name != "version"}


def _field(name: str, value: object) -> Any:
    if isinstance(value, msgspec.Struct):
        return _struct(value)
    if isinstance(value, bytes):
        return _block(name, value)
    if isinstance(value, tuple):
        return [_field(name, item) for item in value]
    if isinstance(value, int) and not isinstance(value, bool):
        return _number(name, value)
    return value


def _block(name: str, value: bytes) -> Any:
    if name in _OPAQUE:
        return f"{len(value)} bytes"
    return value.hex() if name in _HEX else floats(value).tolist()


def _number(name: str, value: int) -> Any:
    if name in _IDS:
        return f"{value:016x}" if value else "none"
    if name == "code":
        return f"G{value:03}" if value else "none"
    return _name_of(_NAMED[name], value) if name in _NAMED else value


def _name_of(kind: Callable[[int], IntEnum], value: int) -> str | int:
    try:
        return kind(value).name.lower()
    except ValueError:
        return value  # a newer sender's code: shown as it came


@example("fairlead topic echo state/joints --count 1")
def echo_command(
    key: KeyArgument,
    deployment: DeploymentOption = None,
    count: Annotated[int, typer.Option(min=0, help="end after so many; 0: until Ctrl-C")] = 0,
    timeout: TimeoutOption = 10.0,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON document on a line")] = False,
) -> None:
    """Print a key's messages: numbers in SI, ids and hashes in hex."""
    chosen = choose_deployment(deployment)
    topic = find_topic(chosen.keys, key)
    with RobotClient(chosen) as client:
        client.wait_anyone()
        joints = _joint_names(client) if topic.kind is JointState else ()
        subscription = client.topic(key, timeout_s=timeout)
        for heard in itertools.islice(subscription, count or None):
            document = {
                "key": short_key(chosen.keys, heard.key),
                "type": topic.kind.__name__,
                **message_document(heard.message),
            }
            _name_values(document, joints)
            echo(json.dumps(document) if as_json else _text(document))


def _joint_names(client: RobotClient) -> tuple[str, ...]:
    """The order of a joint state's numbers; none where no HAL answers."""
    try:
        hal = client.hal_status()
    except NoAnswerError:
        return ()
    return (*hal.joints, *hal.passive_joints)


def _name_values(document: dict[str, Any], joints: tuple[str, ...]) -> None:
    """Numbers become ``joint: number`` where the HAL that sent them said its joints."""
    for field in ("positions", "velocities", "efforts"):
        if joints and len(document[field]) == len(joints):
            document[field] = dict(zip(joints, document[field], strict=True))


def _text(document: dict[str, object]) -> str:
    text: str = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=100)
    return f"---\n{text.rstrip()}"


@example("fairlead topic hz state/joints --count 50")
def hz_command(
    key: KeyArgument,
    deployment: DeploymentOption = None,
    count: Annotated[int, typer.Option(min=2, help="messages to time, all keys together")] = 50,
    timeout: TimeoutOption = 10.0,
    as_json: JsonOption = False,
) -> None:
    """Time a key's messages as they arrive here: rate and the gaps between them."""
    chosen = choose_deployment(deployment)
    arrived: dict[str, list[float]] = {}
    ticks: dict[str, set[int]] = {}
    find_topic(chosen.keys, key)  # a wrong name is said before anybody is waited for
    with RobotClient(chosen) as client:
        client.wait_anyone()
        for heard in itertools.islice(client.topic(key, timeout_s=timeout), count):
            name = short_key(chosen.keys, heard.key)
            arrived.setdefault(name, []).append(heard.at_s)
            tick = getattr(heard.message, "tick", None)
            ticks.setdefault(name, set()).update([] if tick is None else [tick])
    timed = {name: rate_of(times) for name, times in sorted(arrived.items()) if len(times) > 1}
    if as_json:
        print_json([{"key": name} | rates for name, rates in timed.items()])
        return
    header = ("KEY", "MESSAGES", "HZ", "SHORTEST MS", "LONGEST MS")
    print_table(
        header, [(name, *(f"{v:.4g}" for v in rates.values())) for name, rates in timed.items()]
    )
    for name in timed:
        if ticks[name] and len(ticks[name]) < len(arrived[name]):
            repeats = len(arrived[name]) - len(ticks[name])
            echo(
                f"{name}: {repeats} messages repeat a tick: a lockstep world that waits sends "
                "its tick again every 100 ms; the robot's rate is in fairlead status"
            )


def rate_of(times_s: Sequence[float]) -> dict[str, float]:
    """Rate and gaps of at least two arrivals [s, ascending]."""
    gaps = [later - earlier for earlier, later in itertools.pairwise(times_s)]
    return {
        "messages": len(times_s),
        "rate_hz": len(gaps) / max(sum(gaps), 1e-9),
        "shortest_gap_ms": min(gaps) * 1e3,
        "longest_gap_ms": max(gaps) * 1e3,
    }


group = make_group(
    "topic",
    "List, decode and time what a running robot's services publish.",
    {"list": list_command, "echo": echo_command, "hz": hz_command},
)
