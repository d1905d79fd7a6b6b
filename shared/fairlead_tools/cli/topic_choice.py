"""Which key a ``topic`` command is about, and how long it waits for a message."""

from __future__ import annotations

from typing import Annotated

import typer

MAX_WAIT_S = 86_400.0

KeyArgument = Annotated[
    str, typer.Argument(help="key as in `fairlead topic list`; * stands for any name")
]
TimeoutOption = Annotated[
    float,
    typer.Option(min=0.1, max=MAX_WAIT_S, help="seconds without a message before it gives up"),
]
