"""Keys, liveliness tokens and attachments of rmw_zenoh. Pure functions of names.

Data of a topic travels on ``<domain>/<topic>/<type>/<type hash>``, and whoever is there says so
with a token ``@ros2_lv/<domain>/<session>/<node>/<entity>/<kind>/<enclave>/<namespace>/<name>``,
followed for a publisher or a subscription by ``/<topic>/<type>/<type hash>/<quality of
service>``; a slash within a chunk is written ``%``. Worked example, domain 0::

    >>> topic_key(0, "/chatter", "std_msgs/msg/String", "RIHS01_df66")
    '0/chatter/std_msgs::msg::dds_::String_/RIHS01_df66'
    >>> Entity(0, "aac3", 0, 0, "NN", "/", "listener").token
    '@ros2_lv/0/aac3/0/0/NN/%/%/listener'
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass

ADMIN_SPACE = "@ros2_lv"
RELIABLE_10 = "::,10:,:,:,,"
"""Quality of service: reliable, volatile, the last 10 are kept; what is empty is the default."""
NODE, PUBLISHER, SUBSCRIPTION = "NN", "MP", "MS"
NO_HASH = "TypeHashNotSupported"
"""The type hash of every key in ROS 2 Humble, which has none."""

NAME = r"[A-Za-z_][A-Za-z0-9_]*"
TOPIC_NAME = re.compile(rf"(/{NAME})+")
_CHUNKS = 13


def mangled(name: str) -> str:
    """A name as one chunk of a key: ``/arm/state`` is ``%arm%state``; none, or ``/``, is ``%``."""
    return name.replace("/", "%") or "%"


def dds_type(kind: str) -> str:
    """A type as DDS calls it: ``std_msgs::msg::dds_::String_`` for ``std_msgs/msg/String``."""
    *folders, name = kind.split("/")
    return "::".join((*folders, "dds_", f"{name}_"))


def ros_type(dds: str) -> str:
    """The way back from `dds_type`."""
    return dds.replace("::dds_::", "/").replace("::", "/").removesuffix("_")


def topic_key(domain: int, topic: str, kind: str, type_hash: str) -> str:
    """The key on which messages of a topic travel."""
    return f"{domain}/{topic.strip('/')}/{dds_type(kind)}/{type_hash}"


def every_token(domain: int) -> str:
    """The tokens of all that is in a domain."""
    return f"{ADMIN_SPACE}/{domain}/**"


@dataclass(frozen=True)
class Entity:
    """A node, or a publisher or subscription of one.

    Attributes:
        zid: of its Zenoh session.
        node_id, entity_id: numbers within the session; a node's are the same.
        kind: `NODE`, `PUBLISHER` or `SUBSCRIPTION`; others' may also be services and clients.
        topic, type, type_hash: "" for a node.
    """

    domain: int
    zid: str
    node_id: int
    entity_id: int
    kind: str
    namespace: str
    node: str
    topic: str = ""
    type: str = ""
    type_hash: str = ""

    @property
    def token(self) -> str:
        """Its liveliness token."""
        ids = (str(self.domain), self.zid, str(self.node_id), str(self.entity_id))
        names = (self.kind, "%", mangled(self.namespace.rstrip("/")), self.node)
        chunks = [ADMIN_SPACE, *ids, *names]
        if self.topic:
            chunks += [mangled(self.topic), dds_type(self.type), self.type_hash, RELIABLE_10]
        return "/".join(chunks)

    @classmethod
    def parse(cls, token: str) -> Entity | None:
        """What another's token says; None for what is none of a publisher or subscription."""
        chunks = token.split("/")
        if len(chunks) != _CHUNKS or chunks[5] not in (PUBLISHER, SUBSCRIPTION):
            return None
        if not all(number.isdecimal() for number in (chunks[1], chunks[3], chunks[4])):
            return None
        space, node, topic, dds, type_hash = (chunk.replace("%", "/") for chunk in chunks[7:12])
        domain, node_id, entity_id = int(chunks[1]), int(chunks[3]), int(chunks[4])
        return cls(
            domain, chunks[2], node_id, entity_id, chunks[5],
            space, node, topic, ros_type(dds), type_hash,
        )  # fmt: skip


GID_BYTES = 16


def attachment(sequence: int, stamp_ns: int, gid: bytes) -> bytes:
    """What goes with each message, 33 bytes.

    Args:
        sequence: from 1 in each publisher.
        stamp_ns: when it was sent, the system's clock.
        gid: of the publisher, `GID_BYTES`.
    """
    return struct.pack("<qqB", sequence, stamp_ns, GID_BYTES) + gid
