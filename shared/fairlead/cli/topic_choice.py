"""Which key a ``topic`` command is about, and how long it waits for a message."""

from __future__ import annotations

from typing import Annotated

import typer

from fairlead.errors import NoAnswerError
from fairlead.operate.topic_listener import Heard, TopicListener

MAX_WAIT_S = 86_400.0

KeyArgument = Annotated[
    str, typer.Argument(help="key as in `fairlead topic list`; * stands for any name")
]
TimeoutOption = Annotated[
    float,
    typer.Option(min=0.1, max=MAX_WAIT_S, help="seconds without a message before it gives up"),
]


def next_heard(listener: TopicListener, key: str, timeout_s: float) -> Heard:
    """The next publication.

    Raises:
        NoAnswerError: nothing came in time.
    """
    heard = listener.next(timeout_s)
    if heard is None:
        raise NoAnswerError(
            f"topic {key}: nothing published within {timeout_s:g} s; see: fairlead topic list"
        )
    return heard
