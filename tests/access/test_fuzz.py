"""Bytes that nobody means, from a second program that has a name: nobody falls over, nothing moves.

Each name's credentials dial each service that the name may dial, and send on every key that it may
write: messages of that and other kinds, changed, cut, glued together, too deep and too long.
"""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
import zenoh

from bench.equipment.live_robot import LiveRobot
from fairlead.deploy.access import rights
from fairlead.paths import deployment_path, repo_root
from fairlead.wire.endpoints import Endpoints
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.access.party import endpoints_of

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

SKILL = "panda-joint-reach"
NAMES = ("safety", "state_assembler", "runner", "operator")
EACH_KEY = 60
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


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveRobot]:
    folder = tmp_path_factory.mktemp("fuzz")
    scratch = make_scratch(deployment_path("panda_mujoco"), folder / "state", ScratchOptions())
    with scratch_robot(scratch) as robot:
        yield LiveRobot(robot, SKILL)


@pytest.mark.parametrize("name", NAMES)
def test_whatever_a_name_sends_all_services_go_on(live: LiveRobot, name: str) -> None:
    deployment = live.robot.scratch.deployment
    parties = deployment.parties
    before = measured(live)
    chance = random.Random(name)
    sent = 0
    for service in (one for one in parties.services if parties.dials(name, one)):
        keys = {
            (one.key.replace("*", "thing"), one.kind)
            for one in rights(parties)
            if name in one.write and service in one.read and one.kind != "token"
        }
        proof = {"transport": endpoints_of(deployment, name).access["transport"]}
        listen = deployment.services[service].listen
        config = Endpoints(connect=[listen], mode="client", access=proof).config()
        with closing(session_of(config)) as session:
            for key, kind in sorted(keys):
                for _, text in zip(range(EACH_KEY), spoiled(chance), strict=False):
                    if kind == "query":
                        ask(session, key, text)
                    else:
                        session.put(key, text)
                    sent += 1
    print(f"{name}: {sent} messages")
    assert sent >= EACH_KEY
    assert measured(live) == pytest.approx(before, abs=STILL_RAD), "nothing moved"
    check_all_go_on(live)


def test_it_came_and_after_all_of_that_a_goal_succeeds(live: LiveRobot) -> None:
    assert dict(live.client.gate_status().counters)["G001"] > EACH_KEY / 2
    hal = (live.robot.scratch.state_dir / "logs/hal.log").read_text(encoding="utf-8")
    for message in ("SafeChunk", "Lease", "StopLevel"):
        assert f"ignored: {message} that cannot be read" in hal
    live.ready_to_move()
    result = live.start_goal().result(120.0).result
    assert result is not None and result.outcome == "succeeded"


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
