"""What one robot sends: messages of each kind, counted by an operator that only listens."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass

from fairlead.deploy.access import OPERATOR, rights
from fairlead.deploy.deployment import Deployment
from fairlead.wire.bus import Sample
from fairlead.wire.session import ZenohBus

COUNT_S = 5.0


@dataclass(frozen=True)
class Sent:
    """One key of a robot: messages a second, and the mean size of one [bytes]."""

    rate: float
    size: int


def sent(deployment: Deployment) -> Mapping[str, Sent]:
    """By key, behind the robot's."""
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
        messages.clear()
        sizes.clear()
        time.sleep(COUNT_S)
    return {
        key: Sent(count / COUNT_S, round(sizes[key] / count))
        for key, count in sorted(messages.items())
    }
