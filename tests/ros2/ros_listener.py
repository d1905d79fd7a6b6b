"""Listens to ROS 2 topics, by another's implementation of rmw_zenoh, and says what comes.

python -m tests.ros2.ros_listener '{"port": 7447, "domain": 0, "topics": {"/tf": "..."}}'
"""

from __future__ import annotations

import dataclasses
import json
import sys
import threading
from functools import partial
from typing import Any

import numpy as np
from zenoh_ros2_sdk import ROS2Subscriber

from tests.ros2.ros_robot import definition, say, type_hash


def plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        fields = (field.name for field in dataclasses.fields(value))
        return {name: plain(getattr(value, name)) for name in fields if name[0] != "_"}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [plain(one) for one in value] if isinstance(value, list) else value


def main() -> None:
    told = json.loads(sys.argv[1])
    link = {"router_port": told["port"], "domain_id": told["domain"], "node_name": "listener"}
    kept = [
        ROS2Subscriber(
            topic, kind, partial(heard, topic), definition(kind), type_hash=type_hash(kind), **link
        )
        for topic, kind in told["topics"].items()
    ]
    say({"got": "started", "topics": len(kept)})
    threading.Event().wait()


def heard(topic: str, message: Any) -> None:
    say({"got": topic, "message": plain(message)})


if __name__ == "__main__":
    main()
