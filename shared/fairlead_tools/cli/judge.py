"""``fairlead judge``: the gate's own program judges a decision log again."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from fairlead.paths import gate_binary
from fairlead_tools.cli.deployment_choice import JsonOption

EXAMPLE = (
    "fairlead judge out/demo/state/safety/decisions --config robots/panda_mobile/gate.sim.json"
)


def command(
    log: Annotated[
        Path, typer.Argument(exists=True, help="a decision log, or a folder of them: its newest")
    ],
    config: Annotated[
        Path | None,
        typer.Option(
            exists=True,
            dir_okay=False,
            help="another gate file of the same robot: what would it have refused?",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Judge a recorded run again: identical bit for bit, or otherwise under other limits.

    Becomes `fairlead-safety judge`, which lies beside the gate. Exit status: 0 identical, 1
    different, 2 not readable or damaged.
    """
    gate = str(gate_binary())
    words = [] if config is None else ["--config", str(config)]
    os.execv(gate, [gate, "judge", str(log), *words, *(["--json"] if as_json else [])])  # noqa: S606
