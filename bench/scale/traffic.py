"""What one robot sends: messages of each kind, counted by an operator that only listens."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass

from fairlead.deploy.access import OPERATOR, rights
from fairlead.deploy.deployment import Deployment
from fairlead.errors import ServiceError
from fairlead.wire.bus import Sample
from fairlead.wire.session import ZenohBus

COUNT_S = 5.0
TRIES = 4
"""A claim that was lost as all just started is there again in the next."""


@dataclass(frozen=True)
class Sent:
    """One key of a robot: messages a second, and the mean size of one [bytes]."""

    rate: float
    size: int


def sent(deployment: Deployment) -> Mapping[str, Sent]:
    """By key, behind the robot's.

    Raises:
        ServiceError: nothing was released in any try.
    """
    messages: Counter[str] = Counter()
    sizes: Counter[str] = Counter()
    start = f"{deployment.namespace}/{deployment.id}/"

    def hear(sample: Sample) -> None:
        key = sample.key.removeprefix(start)
        messages[key] += 1
        sizes[key] += len(sample.payload)

    with closing(ZenohBus(deployment.tool_endpoints())) as bus:
        for one in rights(deployment.parties):
            if one.kind == "published" and OPERATOR in one.read:
                bus.subscribe(one.key, hear)
        time.sleep(1.0)  # what is there already comes at once, and what is measured is time
        for _ in range(TRIES):
            messages.clear()
            sizes.clear()
            time.sleep(COUNT_S)
            if any(key.startswith("action/safe/") for key in messages):
                break
        else:
            raise ServiceError(f"{deployment.id}: no row was released in {TRIES * COUNT_S:g} s")
    return {
        key: Sent(count / COUNT_S, round(sizes[key] / count))
        for key, count in sorted(messages.items())
    }
