"""The service as a real process on a real Zenoh session."""

import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from fairlead.keys import Keys
from fairlead.messages import JointState, LayoutState, TransformBatch, decode
from fairlead.wire.bus import Qos
from fairlead.wire.session import Endpoints, ZenohBus
from tests.assembler.robot_feed import SKILL, RobotFeed

KEYS = Keys("panda_mobile")
DEADLINE_S = 20.0


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def deployment_file(folder: Path, **options: object) -> tuple[Path, str]:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    path = folder / "deployment.yaml"
    service = {"run": "state_assembler", "listen": endpoint, "options": options}
    content = {
        "robot": "panda_mobile",
        "id": "panda_mobile",
        "services": {"state_assembler": service},
    }
    path.write_text(yaml.safe_dump(content))
    return path, endpoint


def start(path: Path, folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [
            *(sys.executable, "-m", "fairlead_state_assembler"),
            *("--deployment", str(path), "--service", "state_assembler"),
            *("--state-dir", str(folder / "state")),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


@pytest.fixture
def bus(tmp_path: Path) -> Iterator[ZenohBus]:
    """A session beside the running service, once that is alive."""
    path, endpoint = deployment_file(tmp_path)
    process = start(path, tmp_path)
    bus = ZenohBus(Endpoints(connect=[endpoint]))
    alive = threading.Event()
    bus.watch_tokens(KEYS.alive("state_assembler"), lambda _, on: alive.set() if on else None)
    try:
        assert alive.wait(DEADLINE_S), "the assembler did not come up"
        yield bus
    finally:
        bus.close()
        process.terminate()
        output, _ = process.communicate(timeout=DEADLINE_S)
        assert process.returncode == 0, output


def test_wanted_layout_follows_transforms_and_joints_over_zenoh(
    bus: ZenohBus, feed: RobotFeed
) -> None:
    states: list[LayoutState] = []
    answered = threading.Event()

    def on_layout(payload: bytes) -> None:
        states.append(decode(LayoutState, payload))
        answered.set()

    bus.subscribe(KEYS.layout(SKILL), lambda sample: on_layout(sample.payload))
    tf = bus.publisher(KEYS.tf("hal"), TransformBatch, Qos.HOT)
    joints = bus.publisher(KEYS.joints, JointState, Qos.HOT)
    bus.declare_token(KEYS.want_layout(SKILL))
    for _ in range(int(DEADLINE_S / 0.1)):  # a tick is repeated until it is answered
        tf.put(feed.static(1))
        tf.put(feed.moving(1))
        joints.put(feed.joints(1))
        if answered.wait(0.1):
            break
    assert answered.is_set(), "no layout"
    assert (states[0].tick, states[0].skill, states[0].fault) == (1, SKILL, None)


def test_unknown_option_ends_the_process_with_one_line(tmp_path: Path) -> None:
    path, _ = deployment_file(tmp_path, max_age=1)
    process = start(path, tmp_path)
    output, _ = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 1
    assert output == (
        "ERROR fairlead-state-assembler: service state_assembler: options: 1 problem(s):\n"
        "  max_age: unknown key, did you mean max_age_ticks? (valid: max_age_ticks)\n"
    )
