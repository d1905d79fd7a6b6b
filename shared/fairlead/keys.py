"""Every Zenoh key expression fairlead uses, built in one place.

Grammar: ``<namespace>/<robot>/<group>/<noun>[/<source>]``, lower snake case, singular
nouns. Worked example, namespace ``fl``, robot ``panda_mobile``, runner ``runner``::

    >>> keys = Keys("panda_mobile")
    >>> keys.candidate("runner")
    'fl/panda_mobile/action/candidate/runner'

The C++ gate has its own copy of this grammar (``key_table.hpp``); both are tested
against ``tests/golden/keys.json``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from fairlead.errors import ConfigError, expected

_CHUNK = re.compile(r"[a-z0-9][a-z0-9_.\-]{0,63}")


def check_name(who: str, name: str) -> str:
    """Return ``name`` if it may be one chunk of a key, else raise `ConfigError`."""
    if not isinstance(name, str) or not _CHUNK.fullmatch(name):
        raise ConfigError(
            expected(who, "1 to 64 of a-z 0-9 _ . - starting with a letter or digit", repr(name))
        )
    return name


@dataclass(frozen=True)
class Keys:
    """Key expressions of one robot.

    Args:
        robot: the robot's id on the network.
        namespace: first chunk of every key.

    Raises:
        ConfigError: if either cannot be a key chunk.
    """

    robot: str
    namespace: str = "fl"

    def __post_init__(self) -> None:
        check_name("robot id", self.robot)
        check_name("namespace", self.namespace)

    def _key(self, *chunks: str) -> str:
        return "/".join((self.namespace, self.robot, *chunks))

    @property
    def joints(self) -> str:
        """The measured state of every tick (`JointState`); its tick is everybody's clock."""
        return self._key("state", "joints")

    def tf(self, publisher: str) -> str:
        """Transforms of one publisher (`TransformBatch`): the HAL, the assembler, a localiser."""
        return self._key("tf", publisher)

    @property
    def every_tf(self) -> str:
        """Transforms of every publisher: the one wildcard on a hot key, within one robot."""
        return self._key("tf", "*")

    def camera(self, name: str) -> str:
        """Pictures of one camera (`Image`)."""
        return self._key("camera", name)

    def layout(self, skill: str) -> str:
        """State vectors for one skill (`LayoutState`), while somebody wants them."""
        return self._key("state", "layout", skill)

    def candidate(self, source: str) -> str:
        """Chunks that a runner proposes (`ActionChunk`): they move nothing."""
        return self._key("action", "candidate", source)

    @property
    def every_candidate(self) -> str:
        """Proposals of every runner: what the gate judges."""
        return self._key("action", "candidate", "*")

    def safe(self, source: str) -> str:
        """Rows of one runner that the gate released (`SafeChunk`). The gate alone writes here."""
        return self._key("action", "safe", source)

    @property
    def every_safe(self) -> str:
        """Released rows of every runner: what the HAL executes."""
        return self._key("action", "safe", "*")

    @property
    def lease(self) -> str:
        """The gate's permission to move (`Lease`). The gate alone writes here."""
        return self._key("safety", "lease")

    def verdict(self, source: str) -> str:
        """The gate's answers to one runner's chunks (`Verdict`)."""
        return self._key("safety", "verdict", source)

    @property
    def every_verdict(self) -> str:
        """The gate's answers to every runner: for viewers."""
        return self._key("safety", "verdict", "*")

    @property
    def gate_status(self) -> str:
        """What the gate is doing and why (`GateStatus`); also answers a query."""
        return self._key("safety", "status")

    @property
    def stop(self) -> str:
        """Protective stop requests (`StopLevel`), by anyone."""
        return self._key("safety", "stop")

    def gate_command(self, verb: str) -> str:
        """``arm``, ``disarm`` or ``reset``."""
        return self._key("safety", "cmd", verb)

    def claim(self, source: str) -> str:
        """Query: ask for parts (`Claim`), on one's own key: access control knows whose it is."""
        return self._key("safety", "cmd", "claim", source)

    def release(self, source: str) -> str:
        """Query: give a claim of one's own back, or offer it (`Release`)."""
        return self._key("safety", "cmd", "release", source)

    @property
    def hal_status(self) -> str:
        """Who the robot is and how it is paced (`HalStatus`); also answers a query."""
        return self._key("hal", "status")

    def hal_command(self, verb: str) -> str:
        """``reset_episode`` (simulators)."""
        return self._key("hal", "cmd", verb)

    def hal_session(self, session: int) -> str:
        """Liveliness token of one run of a HAL, from before it touches the robot until it ends."""
        return self._key("hal", "session", f"{session:016x}")

    @property
    def every_hal_session(self) -> str:
        """Tokens of every HAL of this robot, of which there may be one."""
        return self._key("hal", "session", "*")

    def goal(self, source: str) -> str:
        """Query: give one runner a `Goal`."""
        return self._key("skill", source, "goal")

    def cancel(self, source: str) -> str:
        """Query: end one runner's goal (`Cancel`)."""
        return self._key("skill", source, "cancel")

    def load(self, source: str) -> str:
        """Query: have one runner load a skill's policy before its goal (`Load`)."""
        return self._key("skill", source, "load")

    def feedback(self, source: str) -> str:
        """How one runner's newest goal goes (`GoalFeedback`)."""
        return self._key("skill", source, "feedback")

    def heartbeat(self, source: str) -> str:
        """Signs of life of one runner while it holds a claim (`Heartbeat`)."""
        return self._key("skill", source, "heartbeat")

    @property
    def every_heartbeat(self) -> str:
        """Signs of life of every runner: without them the gate ends their claims."""
        return self._key("skill", "*", "heartbeat")

    def alive(self, service: str) -> str:
        """Liveliness token of one service: a hint for people, never a watchdog."""
        return self._key("alive", service)

    @property
    def every_alive(self) -> str:
        """Liveliness tokens of all services of this robot."""
        return self._key("alive", "*")

    @property
    def task(self) -> str:
        """A simulator's own success check (`TaskState`)."""
        return self._key("task", "state")

    def want_layout(self, skill: str) -> str:
        """Liveliness token of a runner that wants state vectors for this skill."""
        return self._key("want", "layout", skill)

    @property
    def every_want_layout(self) -> str:
        """Tokens for every skill: whom the assembler works for."""
        return self._key("want", "layout", "*")


def of_person(key: str, person: str) -> str:
    """A person's own key for a command; the key itself where ``person`` is "": nobody's."""
    return f"{key}/{person}" if person else key


def person_of(by: str) -> str:
    """The person in ``ada@lab (fairlead run)``; it proves nothing by itself."""
    return re.split("[ @]", by, maxsplit=1)[0]


def last_chunk(key: str) -> str:
    """The last chunk of a key: the source, camera, publisher or skill it is about."""
    return key.rsplit("/", 1)[-1]
