"""``fairlead topic echo``: the messages of a key, decoded."""

from __future__ import annotations

import json
from typing import Annotated

import typer
import yaml

from fairlead.cli.deployment_choice import DeploymentOption, choose_deployment
from fairlead.cli.topic_choice import KeyArgument, TimeoutOption, next_heard
from fairlead.messages import decode
from fairlead.operate.topic_listener import TopicListener, listening_bus
from fairlead.wire.message_document import message_document
from fairlead.wire.topics import find_topic, short_key

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
        printed = 0
        while count == 0 or printed < count:
            heard = next_heard(listener, key, timeout)
            document = {
                "key": short_key(chosen.keys, heard.key),
                "type": topic.kind.__name__,
                **message_document(decode(topic.kind, heard.payload)),
            }
            typer.echo(json.dumps(document) if as_json else _text(document))
            printed += 1


def _text(document: dict[str, object]) -> str:
    text: str = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=100)
    return f"---\n{text.rstrip()}"
