"""What hal_ros2 takes for a measurement of now, without a ROS 2 system."""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fairlead.errors import ConfigError, ServiceError
from fairlead.robot.manifest import load_robot
from fairlead_hal_ros2.frames import Frames
from fairlead_hal_ros2.joint_states import JointSource, Reading
from fairlead_hal_ros2.robot_fit import check_fit
from fairlead_hal_ros2.ros2_backend import Ros2Backend
from tests.ros2.mobile_options import mobile_options


def turning(*turns: float) -> Any:
    """A backend of one continuous joint that has been measured there."""
    robot = SimpleNamespace(joint_names=["wrist"])
    return SimpleNamespace(_robot=robot, _turning=[0], _turns=np.array(turns or [np.nan]))


def test_a_continuous_joint_that_is_reported_in_another_turn_is_a_fault() -> None:
    """A hold goes on from the last setpoint: it would turn the joint back by a whole turn."""
    arm = turning()
    for position in (3.0, 3.14, 3.3, 9.5 - 3.3):
        Ros2Backend._check_turns(arm, np.array([position]))
    with pytest.raises(ServiceError, match="joint wrist: reported a turn away from the tick befor"):
        Ros2Backend._check_turns(arm, np.array([6.2 - 2 * np.pi]))
    Ros2Backend._check_turns(arm, np.array([6.3]))  # still compared with the last good one


@pytest.mark.parametrize(
    ("factors", "effort"),
    [({"m": 1.0}, 2.0), ({"m": -1.0}, -2.0), ({"m": 0.01}, 200.0), ({"m": 1.0, "n": 1.0}, 2.0)],
)
def test_an_effort_is_that_of_the_joint_by_virtual_work(
    factors: dict[str, float], effort: float
) -> None:
    readings = dict.fromkeys("mn", Reading(0.1, 0.0, 2.0, 0, 0.0))
    source = JointSource("lift", factors, has_effort=True)
    assert source.measure(readings)[2] == pytest.approx(effort)
    moved = source.shares(1e-3)  # what the motors do for a millimetre
    work = sum(2.0 * way for way in moved)
    assert source.measure(readings)[2] * 1e-3 == pytest.approx(work)


def transform(x: float, stamp_s: float) -> Any:
    whole = int(stamp_s)
    stamp = SimpleNamespace(sec=whole, nanosec=int((stamp_s - whole) * 1e9))
    vector, turn = SimpleNamespace(x=x, y=0.0, z=0.0), SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
    one = SimpleNamespace(
        header=SimpleNamespace(frame_id="map", stamp=stamp),
        child_frame_id="cup",
        transform=SimpleNamespace(translation=vector, rotation=turn),
    )
    return SimpleNamespace(transforms=[one])


def test_a_transform_that_is_sent_again_overtaken_or_late_is_none_of_now() -> None:
    heard, now_s = Frames({"cup": "map"}, stale_after_s=0.2), time.time()
    heard.take(transform(1.0, now_s), 10.0)
    assert [pose.translation[0] for pose in heard.new()] == [1.0]
    heard.take(transform(1.0, now_s), 10.1)  # a tracker that has lost it
    heard.take(transform(2.0, now_s - 0.05), 10.1)
    assert heard.new() == []
    heard.take(transform(3.0, now_s + 0.1), 10.4)  # 0.3 s longer under way than the first
    assert heard.new() == []
    heard.take(transform(4.0, now_s + 0.5), 10.6)
    assert [pose.translation[0] for pose in heard.new()] == [4.0]


def test_without_stamps_each_counts() -> None:
    heard = Frames({"cup": "map"}, stale_after_s=0.2)
    for x in (1.0, 2.0):
        heard.take(transform(x, 0.0), 10.0 * x)
        assert [pose.translation[0] for pose in heard.new()] == [x]


def test_hardware_is_not_driven_by_states_that_the_gate_would_not_wait_for() -> None:
    robot = load_robot("panda_mobile")
    kept = tuple(part for part in robot.parts if part.name in ("base", "gripper"))
    mobile = robot.model_copy(update={"parts": kept})
    check_fit(mobile, "hardware", mobile_options("tcp/127.0.0.1:9", stale_after_s=0.25))
    late = mobile_options("tcp/127.0.0.1:9", stale_after_s=0.3)
    with pytest.raises(ConfigError, match=r"stale_after_s: expected at most the profile's state_t"):
        check_fit(mobile, "hardware", late)
