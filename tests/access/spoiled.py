"""Messages that nobody means, and whether all services go on."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from pathlib import Path

import zenoh

from bench.equipment.live_robot import LiveRobot
from fairlead.paths import repo_root

ANSWER_S = 20.0
STILL_RAD = 1e-3
LOG_BYTES = 2_000_000
SAID_BY_WHOEVER_BREAKS = ("Traceback", "panicked", "terminate called", "Exception ignored")
GOLDEN = [path.read_bytes() for path in sorted((repo_root() / "tests/golden").glob("*.bin"))]
BOMBS = (
    b"", b"\x91" * 100_000, b"\x81\xa1a" * 50_000, b"\xdd\xff\xff\xff\xff", b"\xdb\xff\xff\xff\xff",
    b"\xc6\xff\xff\xff\xff", b"\x94\x01" + b"\xcb\x7f\xf8" + bytes(6), bytes(1_000_000),
)  # fmt: skip


def spoiled(chance: random.Random) -> Iterator[bytes]:
    """Messages without end, most of them nearly right."""
    yield from BOMBS
    while True:
        text = bytearray(chance.choice(GOLDEN))
        at = chance.randrange(len(text))
        match chance.randrange(6):
            case 0:
                text[at] ^= 1 << chance.randrange(8)
            case 1:
                del text[at:]
            case 2:
                text[at:at] = chance.randbytes(chance.randrange(1, 40))
            case 3:
                text[at:] = chance.choice(GOLDEN)[at:]
            case 4:
                text[at : at + 9] = b"\xcb\x7f\xf0" + bytes(6)
            case _:
                text = bytearray(chance.randbytes(chance.randrange(200)))
        yield bytes(text)


def session_of(config: dict[str, object]) -> zenoh.Session:
    return zenoh.open(zenoh.Config.from_json5(json.dumps(config)))


def ask(session: zenoh.Session, key: str, text: bytes) -> None:
    """Somebody answers, if only that it is refused."""
    replies = list(session.get(key, payload=text, timeout=ANSWER_S))
    assert replies, (key, text)
    for reply in replies:
        told = reply.ok or reply.err
        assert told is not None and b"Traceback" not in told.payload.to_bytes()


def measured(live: LiveRobot) -> tuple[float, ...]:
    """Where the joints are [rad]."""
    with live.client.joint_states() as states:
        return tuple(next(iter(states)).positions)


def check_all_go_on(live: LiveRobot) -> None:
    assert live.supervisor.died() is None
    live.client.gate_status()
    live.client.hal_status()
    live.client.goal_feedback("runner")
    for log in Path(live.robot.scratch.state_dir / "logs").glob("*.log*"):
        text = log.read_text(encoding="utf-8", errors="replace")
        assert not [word for word in SAID_BY_WHOEVER_BREAKS if word in text], log
        assert len(text) < LOG_BYTES, f"{log}: flooded"
