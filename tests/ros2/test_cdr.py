"""Bytes of each message that is used: as pycdr2, Eclipse Cyclone's, makes them (ours: rosbags)."""

# mypy: disable-error-code="type-arg, valid-type"
# pycdr2's types take arguments that its stubs do not know.

from dataclasses import dataclass
from typing import Any

import pytest
import zenoh.ext
from hypothesis import given
from hypothesis import strategies as st
from pycdr2 import IdlStruct
from pycdr2.types import array, float64, int32, sequence, uint8, uint32

from fairlead.ros2 import messages
from fairlead.ros2.grammar import attachment
from fairlead.ros2.messages import MessageTypes

TYPES = MessageTypes("jazzy")


# Fields in the order of ROS 2's own .msg files.
@dataclass
class Time(IdlStruct):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct):
    stamp: Time
    frame_id: str


@dataclass
class JointState(IdlStruct):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


@dataclass
class TrajectoryPoint(IdlStruct):
    positions: sequence[float64]
    velocities: sequence[float64]
    accelerations: sequence[float64]
    effort: sequence[float64]
    time_from_start: Time


@dataclass
class JointTrajectory(IdlStruct):
    header: Header
    joint_names: sequence[str]
    points: sequence[TrajectoryPoint]


@dataclass
class Dimension(IdlStruct):
    label: str
    size: uint32
    stride: uint32


@dataclass
class ArrayLayout(IdlStruct):
    dim: sequence[Dimension]
    data_offset: uint32


@dataclass
class Float64MultiArray(IdlStruct):
    layout: ArrayLayout
    data: sequence[float64]


@dataclass
class Vector(IdlStruct):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Transform(IdlStruct):
    translation: Vector
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TFMessage(IdlStruct):
    transforms: sequence[TransformStamped]


@dataclass
class Twist(IdlStruct):
    linear: Vector
    angular: Vector


@dataclass
class Pose(IdlStruct):
    position: Vector
    orientation: Quaternion


@dataclass
class PoseWithCovariance(IdlStruct):
    pose: Pose
    covariance: array[float64, 36]


@dataclass
class TwistWithCovariance(IdlStruct):
    twist: Twist
    covariance: array[float64, 36]


@dataclass
class Odometry(IdlStruct):
    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


@dataclass
class Image(IdlStruct):
    header: Header
    height: uint32
    width: uint32
    encoding: str
    is_bigendian: uint8
    step: uint32
    data: sequence[uint8]


@dataclass
class CompressedImage(IdlStruct):
    header: Header
    format: str
    data: sequence[uint8]


@dataclass
class KeyValue(IdlStruct):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct):
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct):
    header: Header
    status: sequence[DiagnosticStatus]


numbers = st.floats(allow_nan=False, width=64)
texts = st.text(st.characters(min_codepoint=1, max_codepoint=0x2FF), max_size=9)
times = st.builds(Time, st.integers(-(2**31), 2**31 - 1), st.integers(0, 10**9 - 1))
headers = st.builds(Header, times, texts)
rows = st.lists(numbers, max_size=4)
vectors = st.builds(Vector, numbers, numbers, numbers)
quaternions = st.builds(Quaternion, numbers, numbers, numbers, numbers)
covariances = st.lists(numbers, min_size=36, max_size=36)
twists = st.builds(Twist, vectors, vectors)
data = st.lists(st.integers(0, 255), max_size=9)
counts = st.integers(0, 2**32 - 1)
points = st.builds(TrajectoryPoint, rows, rows, rows, rows, times)
dimensions = st.builds(Dimension, texts, counts, counts)
statuses = st.builds(
    DiagnosticStatus,
    st.integers(0, 3),
    texts,
    texts,
    texts,
    st.lists(st.builds(KeyValue, texts, texts), max_size=2),
)
MESSAGES: dict[str, st.SearchStrategy[Any]] = {
    messages.JOINT_STATE: st.builds(
        JointState, headers, st.lists(texts, max_size=3), rows, rows, rows
    ),
    messages.JOINT_TRAJECTORY: st.builds(
        JointTrajectory, headers, st.lists(texts, max_size=3), st.lists(points, max_size=2)
    ),
    messages.FLOAT64_MULTI_ARRAY: st.builds(
        Float64MultiArray, st.builds(ArrayLayout, st.lists(dimensions, max_size=2), counts), rows
    ),
    messages.TF_MESSAGE: st.builds(
        TFMessage,
        st.lists(
            st.builds(TransformStamped, headers, texts, st.builds(Transform, vectors, quaternions)),
            max_size=2,
        ),
    ),
    messages.ODOMETRY: st.builds(
        Odometry,
        headers,
        texts,
        st.builds(PoseWithCovariance, st.builds(Pose, vectors, quaternions), covariances),
        st.builds(TwistWithCovariance, twists, covariances),
    ),
    messages.TWIST: twists,
    messages.IMAGE: st.builds(
        Image, headers, counts, counts, texts, st.integers(0, 1), counts, data
    ),
    messages.COMPRESSED_IMAGE: st.builds(CompressedImage, headers, texts, data),
    messages.DIAGNOSTIC_ARRAY: st.builds(DiagnosticArray, headers, st.lists(statuses, max_size=2)),
}


@pytest.mark.parametrize("kind", MESSAGES)
@given(st.data())
def test_a_message_has_the_bytes_that_another_library_makes_of_it(
    kind: str, data: st.DataObject
) -> None:
    theirs = data.draw(MESSAGES[kind]).serialize()
    message = TYPES.decode(kind, theirs)
    assert TYPES.encode(message) == theirs


@given(st.integers(0, 2**63 - 1), st.integers(0, 2**63 - 1), st.binary(min_size=16, max_size=16))
def test_an_attachment_has_the_bytes_that_zenohs_own_serializer_makes_of_it(
    sequence_number: int, stamp_ns: int, gid: bytes
) -> None:
    """rmw_zenoh_cpp gives its three fields to that serializer, in this order."""
    fields = (zenoh.ext.Int64(sequence_number), zenoh.ext.Int64(stamp_ns), gid)
    assert attachment(sequence_number, stamp_ns, gid) == bytes(zenoh.ext.z_serialize(fields))
