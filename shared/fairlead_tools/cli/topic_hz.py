"""``fairlead topic hz``: how often a key's messages come."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Annotated

import typer

from fairlead.operate.client import RobotClient
from fairlead.wire.topics import find_topic, short_key
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.deployment_choice import DeploymentOption, JsonOption, choose_deployment
from fairlead_tools.cli.topic_choice import KeyArgument, TimeoutOption

EXAMPLE = "fairlead topic hz state/joints --count 50"


def command(
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
