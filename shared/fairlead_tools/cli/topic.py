"""``fairlead topic``: look on at what the services publish."""

from __future__ import annotations

import asyncio
import itertools
import json
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from enum import IntEnum
from io import BytesIO
from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer
import yaml

from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError, MessageError, NoAnswerError, expected
from fairlead.messages import (
    Decision,
    GateState,
    Hold,
    Image,
    JointState,
    Message,
    Outcome,
    floats,
)
from fairlead.modes import ControlMode
from fairlead.operate.client import RobotClient
from fairlead.operate.connection import connect
from fairlead.operate.subscription import Heard, Subscription
from fairlead.wire.topics import Topic, find_topic, short_key, topics
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
    if isinstance(value, bytes | memoryview):
        return _block(name, bytes(value))
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
    save: Annotated[
        Path | None,
        typer.Option(metavar="FILE.png", dir_okay=False, help="a camera's next picture, then end"),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON document on a line")] = False,
) -> None:
    """Print a key's messages: numbers in SI, ids and hashes in hex.

    What a camera sees: fairlead topic echo camera/NAME --save seen.png
    """
    chosen = choose_deployment(deployment)
    topic = find_topic(chosen.keys, key)
    if save is not None:
        _check_save(topic, key, save, count)
    with RobotClient(chosen) as client:
        client.wait_anyone()
        joints = _joint_names(client) if topic.kind is JointState else ()
        subscription = client.topic(key, timeout_s=timeout)
        for heard in itertools.islice(subscription, 1 if save else count or None):
            document = {
                "key": short_key(chosen.keys, heard.key),
                "type": topic.kind.__name__,
                **message_document(heard.message),
            }
            _name_values(document, joints)
            echo(json.dumps(document) if as_json else _text(document))
            if save is not None and isinstance(heard.message, Image):
                _write_png(heard.message, save)
                echo(f"wrote {save}", err=True)


def _check_save(topic: Topic, key: str, file: Path, count: int) -> None:
    who = "topic echo --save"
    if topic.kind is not Image:
        raise ConfigError(expected(who, "a camera's key, such as camera/*", repr(key)))
    if file.suffix != ".png":
        raise ConfigError(expected(who, "a file that ends in .png", str(file)))
    if count > 1:
        raise ConfigError(expected(who, "one picture", f"--count {count}"))


def _write_png(image: Image, file: Path) -> None:
    from PIL import Image as Pillow

    who, size = f"camera/{image.camera}", (image.width, image.height)
    if image.encoding_name == "depth32f":
        raise ConfigError(expected(who, "colours (rgb8 or jpeg)", image.encoding_name))
    try:
        if image.encoding_name == "jpeg":
            pixels = Pillow.open(BytesIO(image.data), formats=["jpeg"]).convert("RGB")
        else:
            pixels = Pillow.frombytes("RGB", size, bytes(image.data))
    except (OSError, ValueError) as error:
        what = f"{image.encoding_name} of {image.width} x {image.height}"
        raise MessageError(expected(who, what, str(error))) from None
    pixels.save(file, "png")


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
