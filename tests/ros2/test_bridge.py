"""`fairlead bridge ros2`: what another implementation of rmw_zenoh sees of a robot of ours."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import pytest

from fairlead.keys import Keys
from fairlead.messages import Image, JointState, Outcome, Verdict, decode, floats
from fairlead.operate.client import RobotClient
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.ros2.link import Ros2Link
from fairlead.ros2.node import RosNode
from fairlead.wire.bus import Qos
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.bridge.ros2_bridge import Ros2Bridge
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from fairlead_tools.supervisor.this_host import free_ports
from tests.cli.command import fairlead_command, fairlead_environment, fairlead_here
from tests.hal_mujoco.joint_reach import RUNNER, SKILL, SOURCE
from tests.ros2.ros_process import RosProcess, StartRos

pytestmark = pytest.mark.processes

MOTION = {
    "/cell/joint_states": "sensor_msgs/msg/JointState",
    "/cell/tf": "tf2_msgs/msg/TFMessage",
    "/cell/tf_static": "tf2_msgs/msg/TFMessage",
    "/cell/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}
SIGHT = {
    "/camera/front_1/image_raw": "sensor_msgs/msg/Image",
    "/camera/_2nd/image_raw/compressed": "sensor_msgs/msg/CompressedImage",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}

RAW = Image(session=1, tick=1, camera="front-1", width=2, height=1,
            encoding_name="rgb8", data=b"\1\2\3\4\5\6")  # fmt: skip
JPEG = msgspec.structs.replace(RAW, camera="2nd", encoding_name="jpeg", data=b"\xff\xd8")
REFUSAL = Verdict(
    verdict_id=1, session=1, epoch=1, claim_id=1, source="me", seq=3, outcome=Outcome.REFUSED,
    code=20, row=2, part="arm", axis="x", value=5.0, limit=0.5, margin=-4.5,
    limit_source="robot.yaml", released_first=0, released_last=0, config_hash=bytes(32),
    latency_ns=1,
)  # fmt: skip


class Heard:
    """What came on each topic, and the joint states that were meant."""

    def __init__(self, listener: RosProcess, client: RobotClient) -> None:
        self._listener = listener
        self.states: list[JointState] = []
        client.bus.subscribe(
            client.keys.joints, lambda s: self.states.append(decode(JointState, s.payload))
        )

    def on(self, topic: str) -> list[Any]:
        return [one["message"] for one in list(self._listener.got) if one["got"] == topic]


@contextmanager
def bridge(file: Path, state: Path, router: str) -> Iterator[None]:
    words = fairlead_command("bridge", "ros2", "-d", str(file), "--router", router)
    words += ["--prefix", "/cell"]
    running = subprocess.Popen(words, stdout=subprocess.PIPE, env=fairlead_environment(state))
    with running:
        assert running.stdout is not None
        try:
            said = running.stdout.readline().decode()
            assert said.endswith("as node /cell/fairlead_bridge in domain 0\n"), said
            yield
        finally:
            running.terminate()


def test_joints_transforms_and_verdicts_are_seen_in_ros_2(
    router: str, start_ros: StartRos, tmp_path: Path
) -> None:
    listener = start_ros(module="ros_listener", topics=MOTION)
    scratch = make_scratch(SOURCE, tmp_path / "state", ScratchOptions(options={"runner": RUNNER}))
    with scratch_robot(scratch) as robot, bridge(scratch.file, tmp_path, router):
        heard, hal = Heard(listener, robot.client), robot.client.hal_status()
        robot.client.arm()

        def is_judged() -> bool:  # verdicts before the two have found each other are lost
            run_goal(robot.client, GoalOptions(SKILL, deadline_ticks=10))
            return bool(heard.on("/cell/diagnostics"))

        listener.wait(is_judged, "a verdict to be heard", timeout_s=60.0)
        listener.wait(lambda: all(map(heard.on, MOTION)), "every topic to be heard")
    check_joints(heard, (*hal.joints, *hal.passive_joints))
    check_transforms(heard)
    [status] = heard.on("/cell/diagnostics")[0]["status"]
    assert (status["name"], status["level"]) == ("fairlead gate: runner", 0)
    assert re.match(r"chunk \d+ released: rows ", status["message"])


def test_pictures_and_a_refusal_are_seen_in_ros_2(router: str, start_ros: StartRos) -> None:
    listener = start_ros(module="ros_listener", topics=SIGHT)
    keys, bus = Keys("seen"), ZenohBus(Endpoints(listen=[f"tcp/127.0.0.1:{free_ports(1)[0]}"]))
    node = RosNode(Ros2Link(router=router), "bridge")
    Ros2Bridge(bus, keys, ("joint",), node)
    sent: dict[str, Image | Verdict] = {
        keys.camera("front-1"): RAW,
        keys.camera("2nd"): JPEG,
        keys.verdict("me"): REFUSAL,
    }

    def came(topic: str) -> list[Any]:
        return [one["message"] for one in list(listener.got) if one["got"] == topic]

    def all_came() -> bool:
        for key, message in sent.items():
            if isinstance(message, Image):  # of a new tick: what comes again is not sent again
                sent[key] = message = msgspec.structs.replace(message, tick=message.tick + 1)
            bus.publisher(key, type(message), Qos.STATUS).put(message)
        return all(map(came, SIGHT))

    listener.wait(all_came, "every topic to be heard")
    [image, *_], [small, *_], [diagnostics, *_] = map(came, SIGHT)
    assert (image["width"], image["height"], image["encoding"], image["step"]) == (2, 1, "rgb8", 6)
    assert (image["header"]["frame_id"], image["data"]) == ("front-1", [1, 2, 3, 4, 5, 6])
    assert (small["format"], small["data"]) == ("jpeg", [255, 216])
    [status] = diagnostics["status"]
    assert (status["name"], status["level"]) == ("fairlead gate: me", 2)
    assert status["message"].startswith("G020 limit: chunk 3 refused at row 2, arm x: 5")
    values = {one["key"]: one["value"] for one in status["values"]}
    assert values == {"seq": "3", "code": "20", "part": "arm", "axis": "x"}
    node.close()
    bus.close()


def check_joints(heard: Heard, names: tuple[str, ...]) -> None:
    came = heard.on("/cell/joint_states")
    assert {tuple(one["name"]) for one in came} == {names}
    known = {tuple(floats(state.positions)): state for state in heard.states}
    matching = [
        (one, known[tuple(one["position"])]) for one in came if tuple(one["position"]) in known
    ]
    assert len(matching) >= 5
    for one, state in matching:
        assert one["velocity"] == floats(state.velocities).tolist()
        assert one["effort"] == floats(state.efforts).tolist()
    stamps = [
        one["header"]["stamp"]["sec"] * 10**9 + one["header"]["stamp"]["nanosec"] for one in came
    ]
    assert stamps == sorted(set(stamps)), "no tick comes twice"


def check_transforms(heard: Heard) -> None:
    moving = [one for message in heard.on("/cell/tf") for one in message["transforms"]]
    pairs = {(one["header"]["frame_id"], one["child_frame_id"]) for one in moving}
    assert ("odom", "base_link") in pairs
    [static] = heard.on("/cell/tf_static")[0]["transforms"]
    assert (static["header"]["frame_id"], static["child_frame_id"]) == ("map", "odom")
    assert static["transform"]["rotation"] == {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--prefix", "cell"), "namespace: name: expected a full ROS name such as /arm"),
        (("--domain", "400"), "domain: Input should be less than or equal to 232, got 400"),
        (("--distro", "rolling"), "distro: Input should be 'humble', 'jazzy', 'kilted' or"),
    ],
)
def test_a_wrong_option_is_one_error(words: tuple[str, str], text: str, tmp_path: Path) -> None:
    ended = fairlead_here("bridge", "ros2", "-d", str(SOURCE), *words, state=tmp_path)
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr.startswith("ERROR fairlead bridge ros2: 1 problem(s):")
    assert text in ended.stderr
