"""The backend of hal_ros2 with a robot at the other end: what it tells it, and what it refuses."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from bench.equipment.live_robot import wait_for
from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, FairleadError, MessageError, TransportError
from fairlead.hal.backend import PartCommand
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.ros2.messages import JOINT_STATE, MessageTypes
from fairlead_hal_ros2.joint_states import JointStates
from fairlead_hal_ros2.options import Ros2Options
from fairlead_hal_ros2.ros2_backend import REST_PERIODS, Ros2Backend
from tests.ros2.mobile_options import mobile_options
from tests.ros2.ros_process import FINGERS, JOINTS, NAMES, RosProcess, StartRos, panda_options


@pytest.fixture(scope="module")
def mobile() -> RobotManifest:
    """panda_mobile without its arm and switch: nobody can move those by ROS 2 positions."""
    robot = load_robot("panda_mobile")
    kept = tuple(part for part in robot.parts if part.name in ("base", "gripper"))
    return robot.model_copy(update={"parts": kept})


Connect = Callable[[RobotManifest, Ros2Options], Ros2Backend]


@pytest.fixture
def connect() -> Iterator[Connect]:
    made: list[Ros2Backend] = []

    def backend(robot: RobotManifest, wanted: Ros2Options) -> Ros2Backend:
        profile = "hardware" if robot.base_joints else "sim"
        made.append(Ros2Backend(robot, profile, wanted))
        return made[-1]

    yield backend
    for one in made:
        one.close()


@pytest.fixture
def ros(start_ros: StartRos) -> RosProcess:
    joints = JOINTS | FINGERS | {"torso_height": 0.1}
    return start_ros(joints=joints, positions=list(FINGERS), base=True, tf=True)


def twist(mode: ControlMode, width: int, values: dict[int, float], active: int) -> PartCommand:
    row = np.zeros(width)
    row[list(values)] = list(values.values())
    return PartCommand(mode, "", row, tuple(range(active)))


@pytest.mark.processes
def test_the_base_is_called_as_robot_yaml_does(
    router: str, ros: RosProcess, mobile: RobotManifest, connect: Connect
) -> None:
    other = mobile.model_copy(update={"base_frame": "chassis"})
    assert connect(other, mobile_options(router)).transforms()[0].child == "chassis"


@pytest.mark.processes
def test_a_base_and_a_gripper_do_what_they_are_told_and_hold(
    router: str, ros: RosProcess, mobile: RobotManifest, connect: Connect
) -> None:
    backend = connect(mobile, mobile_options(router))
    wait_for(lambda: any(f.child == "object" for f in frames(backend)), "the tracked frame")
    body = twist(ControlMode.BODY_TWIST, 6, {0: 0.4, 5: 1.0}, 0)
    opening = PartCommand(ControlMode.GRIPPER_POSITION, "", np.array([0.03]), ())

    def turned() -> bool:
        backend.apply({"base": body, "gripper": opening})
        return float(backend.read().positions[2]) > math.pi / 2

    wait_for(turned, "a quarter of a turn")
    assert ros.values("twist")[-1] == pytest.approx([0.4, 0.0, 1.0])
    backend.read()
    across = twist(ControlMode.JOINT_VELOCITY, mobile.n_dof, {0: 0.3}, 3)

    def sideways() -> bool:  # along odom's x, which is now to the right of the base
        backend.apply({"base": across})
        return bool(ros.values("twist")[-1][1] < -0.2)

    wait_for(sideways, "the base to go sideways")
    assert np.linalg.norm(ros.values("twist")[-1][:2]) == pytest.approx(0.3)

    def still() -> bool:
        backend.apply({})
        return bool(ros.values("twist")[-1] == [0.0, 0.0, 0.0])

    wait_for(still, "the base to stand")
    measured = backend.read()
    assert measured.positions[mobile.joint_names.index("panda_gripper")] == pytest.approx(0.03)
    told = len(ros.values("twist"))
    for _ in range(2 * REST_PERIODS):
        backend.apply({})

    def drives() -> bool:  # told in every period: a message may be lost
        backend.apply({"base": body})
        return bool(ros.values("twist")[-1] != [0.0, 0.0, 0.0])

    wait_for(drives, "it to drive again")
    at_rest = [one for one in ros.values("twist")[told:] if one == [0.0, 0.0, 0.0]]
    assert len(at_rest) <= REST_PERIODS, "at rest it is told nothing"


def frames(backend: Ros2Backend) -> list[Any]:
    backend.read()
    found = list(backend.transforms())
    assert found[0].parent == "odom"
    assert {frame.child for frame in found} <= {"base_link", "object"}
    return found


@pytest.mark.processes
def test_what_is_missing_at_the_start_is_said_with_who_is_there(
    router: str, ros: RosProcess, mobile: RobotManifest, connect: Connect
) -> None:
    def refusal(**changes: Any) -> str:
        wanted = mobile_options(router, start_timeout_s=1.0, **changes)
        with pytest.raises(FairleadError) as caught:
            connect(mobile, wanted)
        return str(caught.value).removeprefix("hal_ros2: not ready after 1 s: ")

    assert refusal(joint_states="/arm/joint_states") == (
        "topic /arm/joint_states: joint 'joint1' is missing; nobody publishes on it in domain 0 "
        "(topics of sensor_msgs/msg/JointState: /joint_states)"
    )
    assert refusal(joint_states="/odom").startswith(
        "topic /odom: joint 'joint1' is missing; publisher ros_robot: expected "
        "sensor_msgs/msg/JointState, got nav_msgs/msg/Odometry RIHS01_3cc97d"
    )
    assert refusal(joints=NAMES | {"panda_joint1": {"shoulder": 1.0}}) == (
        "topic /joint_states: joint 'shoulder' is missing (published by ros_robot)"
    )
    assert refusal(base={"child_frame": "base_link"}) == (
        "topic /odom: nothing came (published by ros_robot); its newest message was dropped: "
        "odometry: expected child_frame_id 'base_link' (option base.child_frame), got "
        "'base_footprint'"
    )
    assert refusal(parts={"gripper": {"positions": "/hand"}}) == (
        "topic /hand: nobody listens for std_msgs/msg/Float64MultiArray; is the controller active?"
    )
    assert refusal(domain=7).startswith("topic /joint_states: joint 'joint1' is missing; nobody")
    ros.tell("effortless")
    wait_for(lambda: "has no effort" in refusal(), "the effort to be missed")
    assert "add panda_joint1 to the option without_effort" in refusal()


def test_a_router_that_is_not_there_is_said(mobile: RobotManifest) -> None:
    with pytest.raises(TransportError) as caught:
        Ros2Backend(mobile, "hardware", mobile_options("tcp/127.0.0.1:9"))
    assert str(caught.value) == (
        "ros2: router tcp/127.0.0.1:9: not reached; does it run there, and is the network up? "
        "start it: ros2 run rmw_zenoh_cpp rmw_zenohd"
    )


def test_options_that_do_not_fit_the_robot_are_refused_at_once(mobile: RobotManifest) -> None:
    given = panda_options("tcp/127.0.0.1:9")
    given["parts"]["leg"] = {"trajectory": "/leg"}
    given["joints"] = {"elbow": {"joint1": 0.0}}
    with pytest.raises(ConfigError) as caught:
        Ros2Backend(mobile, "sim", Ros2Options.model_validate(given))
    text = str(caught.value)
    for problem in (
        "joints: expected a name in robot.yaml, got 'elbow' (valid: base_x, base_y, ",
        "parts: expected a name in robot.yaml, got 'arm' (valid: gripper)",
        "parts: expected a name in robot.yaml, got 'leg' (valid: gripper)",
        "joints.elbow: expected factors other than 0",
        "base: expected the topics of part base, got none",
        "without_effort: expected joint base_yaw in it, for odometry has no efforts",
    ):
        assert problem in text
    with pytest.raises(ConfigError, match="got cartesian_delta"):
        Ros2Backend(load_robot("panda_mobile"), "sim", Ros2Options.model_validate(given))
    fixed = panda_options("tcp/127.0.0.1:9") | {"base": {}}
    with pytest.raises(ConfigError, match="robot panda has no base_joints"):
        Ros2Backend(load_robot("panda"), "sim", Ros2Options.model_validate(fixed))


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"router": "localhost"}, "router: expected an endpoint such as tcp/127.0.0.1:7447"),
        ({"domain": -1}, "domain: Input should be greater than or equal to 0, got -1"),
        ({"distro": "foxy"}, "distro: Input should be 'humble', 'jazzy', 'kilted' or 'lyrical'"),
        ({"tf": "tf"}, "tf: expected a full ROS name such as /arm/joint_states, got 'tf'"),
        ({"parts": {"arm": {}}}, "parts.arm: expected trajectory or positions, got neither"),
        ({"stale_after_s": 0.0}, "stale_after_s: Input should be greater than 0, got 0.0"),
        ({"joint_state": "/x"}, "joint_state: unknown key, did you mean joint_states?"),
    ],
)
def test_an_option_that_is_none_is_named(given: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigError) as caught:
        checked_model("options", Ros2Options, given)
    assert text in str(caught.value).replace("name: expected", "expected").replace(
        "router: router:", "router:"
    )


def joint_state(stamp_ns: int, **fields: list[float]) -> Any:
    types = MessageTypes("jazzy")
    given = {"position": [1.0, 2.0], "velocity": [0.0, 0.0], "effort": list[float]()} | fields
    lists = {name: np.array(values, dtype=float) for name, values in given.items()}
    return types.make(JOINT_STATE, header=types.header(stamp_ns), name=["a", "b"], **lists)


def test_joint_states_that_cannot_be_used_are_dropped_with_the_reason() -> None:
    states = JointStates()
    for fields, text in (
        ({"position": [1.0]}, "position: expected 2 numbers, as many as names, got 1"),
        ({"velocity": [1.0]}, "velocity: expected 2 numbers, as many as names, got 1"),
        ({"position": [1.0, math.nan]}, "position: expected finite numbers, got [1.0, nan]"),
    ):
        with pytest.raises(MessageError) as caught:
            states.take(joint_state(5, **fields), 0.0)
        assert str(caught.value) == text
    assert states.newest() == {}
    states.take(joint_state(5), 1.0)
    states.take(joint_state(5, position=[3.0, 4.0]), 2.0)
    assert states.newest()["a"].arrived_s == 1.0, "a stamp that comes again is no new state"
    states.take(joint_state(0, position=[3.0, 4.0]), 3.0)
    assert (states.newest()["a"].position, states.newest()["a"].arrived_s) == (3.0, 3.0)


def test_a_state_that_waited_on_its_way_is_old_when_it_comes() -> None:
    states, sent_ns = JointStates(), time.time_ns()
    for tick in range(100):  # soon, then 1.5 s late; the sender's clock is 3 s behind
        late_s = 0.002 if tick < 50 else 1.5
        came_s = 10.0 + 0.02 * tick + late_s
        states.take(joint_state(sent_ns - 3 * 10**9 + tick * 20_000_000), came_s)
        newest_s = states.newest()["a"].arrived_s
        assert came_s - newest_s == pytest.approx(late_s - 0.002, abs=1e-6)
    simulated = JointStates()
    for tick in range(1, 50):
        simulated.take(joint_state(tick * 10_000_000), 0.02 * tick)
        assert simulated.newest()["a"].arrived_s == 0.02 * tick
