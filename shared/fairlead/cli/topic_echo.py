"""``fairlead topic echo``: the messages of a key, decoded."""

from __future__ import annotations

import json
from typing import Annotated, Any

import typer
import yaml

from fairlead.cli.console import echo
from fairlead.cli.deployment_choice import DeploymentOption, choose_deployment
from fairlead.cli.topic_choice import KeyArgument, TimeoutOption, next_heard
from fairlead.deploy.deployment import Deployment
from fairlead.errors import NoAnswerError
from fairlead.messages import HalStatus, JointState, StatusQuery, decode
from fairlead.operate.topic_listener import TopicListener, listening_bus
from fairlead.wire.bus import Bus
from fairlead.wire.message_document import message_document
from fairlead.wire.topics import find_topic, short_key

NAMES_TIMEOUT_S = 2.0
EXAMPLE = "fairlead topic echo state/joints --count 1"


def command(
    key: KeyArgument,
    deployment: DeploymentOption = None,
    count: Annotated[int, typer.Option(min=0, help="end after so many; 0: until Ctrl-C")] = 0,
    timeout: TimeoutOption = 10.0,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON document on a line")] = False,
) -> None:
    """Print a key's messages: numbers in SI, ids and hashes in hex."""
    chosen = choose_deployment(deployment)
    topic = find_topic(chosen.keys, key)
    with listening_bus(chosen) as bus:
        listener = TopicListener(bus, [topic.key_expr])
        joints = _joint_names(bus, chosen) if topic.kind is JointState else ()
        printed = 0
        while count == 0 or printed < count:
            heard = next_heard(listener, key, timeout)
            document = {
                "key": short_key(chosen.keys, heard.key),
                "type": topic.kind.__name__,
                **message_document(decode(topic.kind, heard.payload)),
            }
            _name_values(document, joints)
            echo(json.dumps(document) if as_json else _text(document))
            printed += 1


def _joint_names(bus: Bus, deployment: Deployment) -> tuple[str, ...]:
    """The order of a joint state's numbers; none where no HAL answers."""
    try:
        reply = bus.query(deployment.keys.hal_status, StatusQuery(), NAMES_TIMEOUT_S)
    except NoAnswerError:
        return ()
    hal = decode(HalStatus, reply)
    return (*hal.joints, *hal.passive_joints)


def _name_values(document: dict[str, Any], joints: tuple[str, ...]) -> None:
    """Numbers become ``joint: number`` where the HAL that sent them said its joints."""
    for field in ("positions", "velocities", "efforts"):
        if joints and len(document[field]) == len(joints):
            document[field] = dict(zip(joints, document[field], strict=True))


def _text(document: dict[str, object]) -> str:
    text: str = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=100)
    return f"---\n{text.rstrip()}"
