"""Keys, tokens, ids, hashes and bytes: against what rmw_zenoh documents, and others' code."""

from __future__ import annotations

import struct
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from zenoh_ros2_sdk import keyexpr
from zenoh_ros2_sdk.attachment import Attachment
from zenoh_ros2_sdk.entity import EndpointEntity, EntityKind, NodeEntity

from fairlead.errors import MessageError
from fairlead.ros2.grammar import (
    PUBLISHER,
    RELIABLE_10,
    SUBSCRIPTION,
    Entity,
    attachment,
    dds_type,
    ros_type,
    topic_key,
)
from fairlead.ros2.messages import (
    FLOAT64_MULTI_ARRAY,
    IMAGE,
    JOINT_STATE,
    JOINT_TRAJECTORY,
    ODOMETRY,
    TF_MESSAGE,
    TWIST,
    MessageTypes,
    gid_of,
)
from tests.ros2.ros_robot import type_hash

TYPES = MessageTypes("jazzy")
STRING = "std_msgs/msg/String"
STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
ZID = "aac3178e146ba6f1fc6e6a4085e77f21"

# As `ros2 topic info --verbose` shows them, from Jazzy on.
PUBLISHED = {
    STRING: STRING_HASH,
    JOINT_STATE: "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    TF_MESSAGE: "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    ODOMETRY: "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    JOINT_TRAJECTORY: "RIHS01_179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e",
    FLOAT64_MULTI_ARRAY: "RIHS01_1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f",
    TWIST: "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    IMAGE: "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
}


def test_keys_and_tokens_are_those_of_the_middlewares_document() -> None:
    node = Entity(0, ZID, 0, 0, "NN", "/", "listener")
    assert node.token == f"@ros2_lv/0/{ZID}/0/0/NN/%/%/listener"
    heard = Entity(0, ZID, 0, 10, "MS", "/", "listener", "/chatter", STRING, STRING_HASH)
    assert heard.token == (
        f"@ros2_lv/0/{ZID}/0/10/MS/%/%/listener/%chatter/std_msgs::msg::dds_::String_/"
        f"{STRING_HASH}/::,10:,:,:,,"
    )
    assert Entity.parse(heard.token) == heard
    key = f"0/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}"
    assert topic_key(0, "/chatter", STRING, STRING_HASH) == key


@pytest.mark.parametrize(
    "token",
    ["", "@ros2_lv/0/a/0/0/NN/%/%/talker", "@ros2_lv/x/a/0/1/MP/%/%/n/%t/d/h/q", "a/b", "/" * 12],
)
def test_a_token_that_is_of_no_publisher_or_subscription_says_nothing(token: str) -> None:
    assert Entity.parse(token) is None


@pytest.mark.parametrize(("namespace", "topic"), [("/", "/tf"), ("/cell/left", "/cell/left/odom")])
@pytest.mark.parametrize("kind", [PUBLISHER, SUBSCRIPTION])
def test_another_implementation_makes_the_same_keys(namespace: str, topic: str, kind: str) -> None:
    ours = Entity(42, ZID, 3, 7, kind, namespace, "arm", topic, TWIST, PUBLISHED[TWIST])
    node = NodeEntity(42, ZID, 3, "arm", namespace)
    dds = "geometry_msgs::msg::dds_::Twist_"
    theirs = EndpointEntity(
        node, 7, EntityKind(kind), topic, dds, PUBLISHED[TWIST], RELIABLE_10
    )  # fmt: skip
    assert ours.token == keyexpr.endpoint_liveliness_keyexpr(theirs)
    key = keyexpr.topic_keyexpr(42, topic, dds, PUBLISHED[TWIST])
    assert topic_key(42, topic, TWIST, PUBLISHED[TWIST]) == key
    assert (dds_type(TWIST), ros_type(dds)) == (dds, TWIST)


def test_an_attachment_is_read_by_another_implementation() -> None:
    gid = bytes(range(16))
    data = attachment(5, 1_700_000_000_123_456_789, gid)
    read = Attachment.from_bytes(data)
    assert (read.sequence_id, read.timestamp_ns, read.gid) == (5, 1_700_000_000_123_456_789, gid)
    assert len(data) == 33


@pytest.mark.parametrize(
    ("token", "gid"),
    [
        (f"@ros2_lv/0/{ZID}/0/0/NN/%/%/listener", "5bd72f4daf53c0bb00c7394e7fc19547"),
        (
            "@ros2_lv/0/8b20917502ee955ac4476e0266340d5c/0/10/MP/%/%/talker/%chatter/"
            f"std_msgs::msg::dds_::String_/{STRING_HASH}/::,7:,:,:,,",
            "eb85fa883b7846dc448a4501890ad062",
        ),
        ("x" * 300, "5435c87d60b4d1a57abcd72aea375212"),
    ],
)
def test_an_id_is_what_the_middlewares_own_code_makes_of_the_token(token: str, gid: str) -> None:
    assert gid_of(token).hex() == gid


@pytest.mark.parametrize("kind", PUBLISHED)
def test_type_hashes_are_the_published_ones_and_those_of_another_implementation(kind: str) -> None:
    assert TYPES.hash_of(kind) == PUBLISHED[kind] == type_hash(kind)
    assert MessageTypes("lyrical").hash_of(kind) == PUBLISHED[kind]
    assert MessageTypes("humble").hash_of(kind) == "TypeHashNotSupported"


def test_the_bytes_of_a_joint_state_are_those_a_ros_2_node_sends() -> None:
    message = TYPES.make(
        JOINT_STATE,
        header=TYPES.header(1_000_000_002, "base"),
        name=["j1", "j2"],
        position=np.array([0.5, -1.0]),
        velocity=np.zeros(0),
        effort=np.zeros(0),
    )
    data = struct.pack("<4B iI I5s3x I I3sx I3sx", 0, 1, 0, 0, 1, 2, 5, b"base\0", 2,
                       3, b"j1\0", 3, b"j2\0")  # fmt: skip
    data += struct.pack("<I4x2d II", 2, 0.5, -1.0, 0, 0)
    assert TYPES.encode(message) == data
    decoded = TYPES.decode(JOINT_STATE, data)
    assert (decoded.name, decoded.position.tolist()) == (["j1", "j2"], [0.5, -1.0])


WHOLE = TYPES.encode(
    TYPES.make(
        JOINT_STATE,
        header=TYPES.header(5, "frame"),
        name=["one", "two"],
        position=np.ones(2),
        velocity=np.ones(2),
        effort=np.ones(2),
    )
)


@given(st.binary(max_size=80), st.integers(0, len(WHOLE)), st.integers(0, len(WHOLE)))
def test_bytes_that_are_no_message_are_refused_whatever_they_are(
    junk: bytes, head: int, tail: int
) -> None:
    try:
        TYPES.decode(JOINT_STATE, WHOLE[:head] + junk + WHOLE[tail:])
    except MessageError as error:
        assert str(error).startswith(f"expected {JOINT_STATE} (")


@pytest.mark.processes
def test_without_the_extra_packages_the_error_says_how_to_get_them() -> None:
    code = "import sys; sys.modules['rosbags.serde.errors'] = None; import fairlead.ros2.messages"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert ended.stderr.splitlines()[-1].endswith("install them: pip install 'fairlead[ros2]'"), (
        ended.stderr
    )
