"""``fairlead topic list``: which keys carry something right now."""

from __future__ import annotations

import asyncio
from collections import Counter
from contextlib import suppress
from typing import Annotated

import typer

from fairlead.deploy.deployment import Deployment
from fairlead.operate.connection import connect
from fairlead.operate.subscription import Heard, Subscription
from fairlead.wire.topics import short_key, topics
from fairlead_tools.cli.console import print_json, print_table
from fairlead_tools.cli.deployment_choice import DeploymentOption, JsonOption, choose_deployment
from fairlead_tools.cli.topic_choice import MAX_WAIT_S

EXAMPLE = "fairlead topic list --seconds 2"


def command(
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
