"""``fairlead topic echo``: the messages of a key, decoded."""

from __future__ import annotations

import itertools
import json
from typing import Annotated, Any

import typer
import yaml

from fairlead.errors import NoAnswerError
from fairlead.messages import JointState
from fairlead.operate.client import RobotClient
from fairlead.wire.topics import find_topic, short_key
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.deployment_choice import DeploymentOption, choose_deployment
from fairlead_tools.cli.message_document import message_document
from fairlead_tools.cli.topic_choice import KeyArgument, TimeoutOption

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
