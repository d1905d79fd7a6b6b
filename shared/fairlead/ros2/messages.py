"""ROS 2 messages: their types, hashes and bytes (CDR), by the package rosbags."""

from __future__ import annotations

from typing import Any

from fairlead.errors import ConfigError, MessageError
from fairlead.ros2.grammar import NO_HASH
from fairlead.ros2.link import Distro

try:
    import xxhash
    from rosbags.serde.errors import SerdeError
    from rosbags.typesys import Stores, get_typestore
except ImportError as error:
    raise ConfigError(
        f"ros2: expected the packages of the extra `ros2`, got none ({error}); install them: "
        "pip install 'fairlead[ros2]'"
    ) from None

JOINT_STATE = "sensor_msgs/msg/JointState"
TF_MESSAGE = "tf2_msgs/msg/TFMessage"
ODOMETRY = "nav_msgs/msg/Odometry"
JOINT_TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
FLOAT64_MULTI_ARRAY = "std_msgs/msg/Float64MultiArray"
TWIST = "geometry_msgs/msg/Twist"
IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"
DIAGNOSTIC_ARRAY = "diagnostic_msgs/msg/DiagnosticArray"


class MessageTypes:
    """The message types of one ROS 2 distribution.

    A message has its type's fields as attributes; lists of numbers are numpy arrays.
    """

    def __init__(self, distro: Distro) -> None:
        self._has_hashes = distro != "humble"
        self._store = get_typestore(Stores(f"ros2_{distro}"))

    def hash_of(self, kind: str) -> str:
        """The type hash in keys: ``RIHS01_`` and a SHA-256."""
        return self._store.hash_rihs01(kind) if self._has_hashes else NO_HASH

    def make(self, kind: str, **fields: Any) -> Any:
        """A message with all its fields.

        Args:
            kind: such as `JOINT_STATE`.
        """
        return self._store.types[kind](**fields)

    def stamp(self, stamp_ns: int) -> Any:
        """A time; nanoseconds since 1970."""
        seconds, rest = divmod(stamp_ns, 10**9)
        return self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)

    def header(self, stamp_ns: int, frame: str = "") -> Any:
        """A header; stamp 0 stands for "now" in a trajectory."""
        return self.make("std_msgs/msg/Header", stamp=self.stamp(stamp_ns), frame_id=frame)

    def encode(self, message: Any) -> bytes:
        """The message's bytes, little-endian CDR with its header."""
        kind = message.__msgtype__
        return bytes(self._store.serialize_cdr(message, kind, little_endian=True))

    def decode(self, kind: str, data: bytes) -> Any:
        """The message in some bytes.

        Raises:
            MessageError: they are no such message.
        """
        try:
            return self._store.deserialize_cdr(data, kind)
        except (SerdeError, UnicodeDecodeError) as error:
            raise MessageError(f"expected {kind} ({len(data)} bytes): {error}") from None


def gid_of(token: str) -> bytes:
    """The id of whoever declared a token: 16 bytes, XXH3-128 of its text, low byte first."""
    return xxhash.xxh3_128_digest(token.encode())[::-1]


def stamp_ns_of(header: Any) -> int:
    """Nanoseconds since 1970 in a header; 0 where its sender wrote none."""
    return int(header.stamp.sec) * 10**9 + int(header.stamp.nanosec)
