"""Every published key of a robot and the message type it carries: for tools that look on.

Services name their keys themselves; only tools ask for "whatever is there".
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from fairlead.errors import ConfigError, expected
from fairlead.keys import Keys
from fairlead.messages import (
    ActionChunk,
    GateStatus,
    GoalFeedback,
    HalStatus,
    Heartbeat,
    Image,
    JointState,
    LayoutState,
    Lease,
    Message,
    SafeChunk,
    StopLevel,
    TaskState,
    TransformBatch,
    Verdict,
)

EVERY = "*"


@dataclass(frozen=True)
class Topic:
    """One key, or a family of keys that ends in (or holds) a ``*``, and its message type."""

    key_expr: str
    kind: type[Message]

    def matches(self, key: str) -> bool:
        """Whether a key, or a narrower family, belongs to this topic."""
        ours, theirs = self.key_expr.split("/"), key.split("/")
        return len(ours) == len(theirs) and all(
            mine in (EVERY, other) for mine, other in zip(ours, theirs, strict=True)
        )


def topics(keys: Keys) -> tuple[Topic, ...]:
    """Every published key of one robot, in the order state, action, safety, skill."""
    return (
        Topic(keys.joints, JointState),
        Topic(keys.every_tf, TransformBatch),
        Topic(keys.camera(EVERY), Image),
        Topic(keys.layout(EVERY), LayoutState),
        Topic(keys.task, TaskState),
        Topic(keys.hal_status, HalStatus),
        Topic(keys.every_candidate, ActionChunk),
        Topic(keys.every_safe, SafeChunk),
        Topic(keys.lease, Lease),
        Topic(keys.every_verdict, Verdict),
        Topic(keys.gate_status, GateStatus),
        Topic(keys.stop, StopLevel),
        Topic(keys.every_heartbeat, Heartbeat),
        Topic(keys.feedback(EVERY), GoalFeedback),
    )


def short_key(keys: Keys, key: str) -> str:
    """A key without namespace and robot: ``state/joints``."""
    return key.removeprefix(f"{keys.namespace}/{keys.robot}/")


def find_topic(keys: Keys, name: str) -> Topic:
    """The topic that ``name`` stands for: ``state/joints``, ``tf/*`` or a whole key.

    Raises:
        ConfigError: listing the keys there are.
    """
    prefix = f"{keys.namespace}/{keys.robot}/"
    key = name if name.startswith(prefix) else prefix + name
    for topic in topics(keys):
        if topic.matches(key):
            return Topic(key, topic.kind)
    raise ConfigError(expected("topic", "a published key", repr(name), _names(keys)))


def _names(keys: Keys) -> Iterable[str]:
    return (short_key(keys, topic.key_expr) for topic in topics(keys))
