"""A node of a ROS 2 system: what it publishes, what it hears, and who else is there."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator
from typing import Any

from fairlead.errors import MessageError, TransportError
from fairlead.ros2.grammar import (
    NODE,
    PUBLISHER,
    SUBSCRIPTION,
    Entity,
    attachment,
    every_token,
    topic_key,
)
from fairlead.ros2.link import Ros2Link
from fairlead.ros2.messages import MessageTypes, gid_of
from fairlead.wire.bus import Sample
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus


class RosPublisher:
    """One topic that a `RosNode` publishes on; for any thread."""

    def __init__(self, bus: ZenohBus, types: MessageTypes, key: str, token: str) -> None:
        self._types, self._gid, self._numbers = types, gid_of(token), itertools.count(1)
        self._publisher = bus.foreign_publisher(key)

    def publish(self, message: Any) -> None:
        """Send a message of the topic's type; never waits."""
        added = attachment(next(self._numbers), time.time_ns(), self._gid)
        self._publisher.put_bytes(self._types.encode(message), added)


class RosNode:
    """One node, with a Zenoh session of its own, a client of the ROS 2 system's router.

    Zenoh makes a broken link to the router anew by itself.

    Args:
        name: of the node.

    Raises:
        TransportError: the router cannot be reached.
    """

    def __init__(self, link: Ros2Link, name: str) -> None:
        self._link, self._name = link, name
        self.types = MessageTypes(link.distro)
        self._ids = itertools.count()
        # Single steps only, so without a lock.
        self._others: dict[str, Entity] = {}  # by token
        self._refused: dict[str, str] = {}  # by topic
        try:
            self._bus = ZenohBus(Endpoints(connect=[link.router], mode="client"))
        except TransportError:
            raise TransportError(
                f"ros2: router {link.router}: not reached; does it run there, and is the network "
                "up? start it: ros2 run rmw_zenoh_cpp rmw_zenohd"
            ) from None
        self._declare(NODE)
        self._bus.watch_tokens(every_token(link.domain), self._on_token)

    def publisher(self, topic: str, kind: str) -> RosPublisher:
        """Publish messages of type ``kind`` on a topic."""
        entity = self._declare(PUBLISHER, topic, kind)
        return RosPublisher(self._bus, self.types, self._key(topic, kind), entity.token)

    def subscribe(self, topic: str, kind: str, handler: Callable[[Any], None]) -> None:
        """Call ``handler`` with each message, on Zenoh's receive thread.

        What is no such message is dropped and logged, as is one for which it raises `MessageError`.
        """

        def on_sample(sample: Sample) -> None:
            try:
                handler(self.types.decode(kind, sample.payload))
            except MessageError as error:
                self._refused[topic] = str(error)
                raise
            self._refused.pop(topic, None)

        self._declare(SUBSCRIPTION, topic, kind)
        self._bus.subscribe(self._key(topic, kind), on_sample)

    def publishers(self, topic: str) -> list[Entity]:
        """Who publishes on a topic now, with whatever type."""
        return [entity for entity in self._find(PUBLISHER) if entity.topic == topic]

    def has_listener(self, topic: str, kind: str) -> bool:
        """Whether somebody else listens to a topic, and for messages of that type."""
        return any(
            (entity.topic, entity.type) == (topic, kind) for entity in self._find(SUBSCRIPTION)
        )

    def refusal(self, topic: str) -> str:
        """Why the newest message of a topic was dropped; "" if it was not."""
        return self._refused.get(topic, "")

    def topics(self, kind: str) -> list[str]:
        """Topics on which others publish messages of that type."""
        return sorted({one.topic for one in self._find(PUBLISHER) if one.type == kind})

    def close(self) -> None:
        """Leave the ROS 2 system."""
        self._bus.close()

    def _key(self, topic: str, kind: str) -> str:
        return topic_key(self._link.domain, topic, kind, self.types.hash_of(kind))

    def _declare(self, kind: str, topic: str = "", type_name: str = "") -> Entity:
        number = next(self._ids)
        entity = Entity(
            self._link.domain,
            self._bus.zid,
            0,
            number,
            kind,
            self._link.namespace,
            self._name,
            topic,
            type_name,
            self.types.hash_of(type_name) if type_name else "",
        )
        self._bus.declare_token(entity.token)
        return entity

    def _on_token(self, token: str, alive: bool) -> None:
        entity = Entity.parse(token)
        if entity is None or entity.zid == self._bus.zid:
            return
        if alive:
            self._others[token] = entity
        else:
            self._others.pop(token, None)

    def _find(self, kind: str) -> Iterator[Entity]:
        return (entity for entity in list(self._others.values()) if entity.kind == kind)
