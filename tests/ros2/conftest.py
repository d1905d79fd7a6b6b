"""A router, and programs that speak ROS 2 through it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.supervisor.this_host import free_ports
from tests.ros2.ros_process import RosProcess, StartRos


@pytest.fixture(scope="module")
def router() -> Iterator[str]:
    """The endpoint of a Zenoh router."""
    endpoint = f"tcp/127.0.0.1:{free_ports(1)[0]}"
    bus = ZenohBus(Endpoints(listen=[endpoint], mode="router"))
    yield endpoint
    bus.close()


@pytest.fixture
def start_ros(router: str, tmp_path: Path) -> Iterator[StartRos]:
    started: list[RosProcess] = []

    def start(module: str = "ros_robot", **told: Any) -> RosProcess:
        port = int(router.rpartition(":")[2])
        started.append(RosProcess(tmp_path, module, port=port, domain=0, **told))
        return started[-1]

    yield start
    for robot in started:
        robot.end()
