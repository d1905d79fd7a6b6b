"""The assembler on a bus, in one process."""

import asyncio
import logging
import re
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
import yaml

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError
from fairlead.keys import Keys
from fairlead.messages import JointState, LayoutState, Lease, TransformBatch, decode, encode
from fairlead.paths import SKILLS_VARIABLE, rskill_dir
from fairlead.robot.manifest import RobotManifest
from fairlead.wire.bus import Qos, Sample, Undeclare
from fairlead.wire.memory_bus import MemoryBus
from fairlead_state_assembler import transport
from fairlead_state_assembler.core import AssemblerCore
from fairlead_state_assembler.options import AssemblerOptions
from fairlead_state_assembler.publishers import Publishers
from fairlead_state_assembler.transport import AssemblerTransport
from tests.assembler.robot_feed import SKILL, RobotFeed
from tests.client.turns import turns, until

KEYS = Keys("panda_mobile")


class Wire:
    """Another service's view of the bus."""

    def __init__(self, robot: RobotManifest, log: pytest.LogCaptureFixture) -> None:
        self.log = log
        self.bus = MemoryBus()
        self.seen: list[Sample] = []
        self.bus.subscribe(KEYS.layout(SKILL), self.seen.append)
        self.bus.subscribe(KEYS.tf("state_assembler"), self.seen.append)
        self.transport = AssemblerTransport(
            self.bus, KEYS, "state_assembler", AssemblerCore(robot, Publishers())
        )
        self.tf = self.bus.publisher(KEYS.tf("hal"), TransformBatch, Qos.HOT)
        self.joints = self.bus.publisher(KEYS.joints, JointState, Qos.HOT)

    def tick(self, feed: RobotFeed, tick: int) -> None:
        self.tf.put(feed.static(tick))
        self.tf.put(feed.moving(tick))
        self.joints.put(feed.joints(tick))

    def keys_seen(self) -> list[str]:
        keys = [sample.key for sample in self.seen]
        self.seen.clear()
        return keys

    async def want(self, skill: str = SKILL) -> Undeclare:
        """Want a skill's layout; the assembler has said so when this returns."""
        token = self.bus.declare_token(KEYS.want_layout(skill))
        await self.said(f"assembl(ing|e) for {skill}")
        return token

    async def said(self, text: str) -> None:
        await until(lambda: any(re.search(text, line) for line in self.log.messages))
        self.log.clear()


@pytest_asyncio.fixture
async def wire(robot: RobotManifest, caplog: pytest.LogCaptureFixture) -> AsyncIterator[Wire]:
    caplog.set_level(logging.INFO)
    wire = Wire(robot, caplog)
    following = asyncio.create_task(wire.transport.follow_wants())
    yield wire
    following.cancel()


@pytest.mark.asyncio
async def test_links_are_published_every_tick_and_layouts_only_while_wanted(
    wire: Wire, feed: RobotFeed
) -> None:
    wire.tick(feed, 1)
    assert wire.keys_seen() == [KEYS.tf("state_assembler")]
    token = await wire.want()
    assert wire.keys_seen() == [KEYS.layout(SKILL)]
    wire.tick(feed, 2)
    assert wire.keys_seen() == [KEYS.layout(SKILL), KEYS.tf("state_assembler")]
    token.undeclare()
    await wire.said(f"no longer assembling for {SKILL}")
    wire.tick(feed, 3)
    assert wire.keys_seen() == [KEYS.tf("state_assembler")]


@pytest.mark.asyncio
async def test_layout_carries_the_tick_of_the_joints(wire: Wire, feed: RobotFeed) -> None:
    await wire.want()
    wire.tick(feed, 1)
    state = decode(LayoutState, wire.seen[0].payload)
    assert (state.tick, state.fault) == (1, None)


@pytest.mark.asyncio
async def test_a_skill_that_cannot_be_looked_at_is_no_reason_to_end(
    wire: Wire, feed: RobotFeed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(SKILLS_VARIABLE, str(tmp_path / ("x" * 300)))
    wire.bus.declare_token(KEYS.want_layout("elsewhere"))
    await wire.said("cannot assemble for elsewhere: .*File name too long")
    await wire.want()
    wire.tick(feed, 1)
    assert KEYS.layout(SKILL) in wire.keys_seen()


@pytest.mark.asyncio
async def test_whose_joint_states_these_are_is_the_gates_word(
    wire: Wire, feed: RobotFeed, robot: RobotManifest
) -> None:
    wire.bus.publisher(KEYS.lease, Lease, Qos.HOT).put(feed.lease())
    wire.tick(RobotFeed(robot, session=12), 900)
    assert wire.keys_seen() == []
    wire.tick(feed, 1)
    assert wire.keys_seen() == [KEYS.tf("state_assembler")]


@pytest.mark.asyncio
async def test_message_that_does_not_fit_is_dropped_and_named_once(
    wire: Wire, feed: RobotFeed, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            wire.joints.put_bytes(encode(feed.static(1)))
    assert len(caplog.messages) == 1
    assert caplog.messages[0].startswith(
        "fl/panda_mobile/state/joints: dropped: expected JointState v1, got "
    )
    wire.tick(feed, 1)
    assert wire.keys_seen() == [KEYS.tf("state_assembler")]


@pytest.mark.asyncio
async def test_skill_that_cannot_be_loaded_is_logged_with_its_reason(
    wire: Wire, caplog: pytest.LogCaptureFixture
) -> None:
    wire.bus.declare_token(KEYS.want_layout("no-such-skill"))
    await until(lambda: caplog.messages)
    assert caplog.messages[0].startswith(
        "cannot assemble for no-such-skill: skill 'no-such-skill': no file "
    )


@pytest.mark.asyncio
@pytest.mark.parametrize("name", ["a" * 300, "*", "Upper"])
async def test_a_want_that_is_no_skills_name_is_logged_and_the_next_one_answered(
    wire: Wire, name: str
) -> None:
    wire.bus.declare_token(KEYS.want_layout(name))
    await wire.said("wanted: skill: expected 1 to 64 of a-z")
    await wire.want()


@pytest.mark.asyncio
async def test_more_skills_than_one_run_answers_for_are_logged(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(transport, "MOST_SKILLS", 1)
    await wire.want()
    wire.bus.declare_token(KEYS.want_layout("another"))
    await wire.said("wanted: skill another: expected at most 1 skills in one run")


@pytest.mark.asyncio
async def test_ticks_are_answered_while_a_long_manifest_is_read(
    wire: Wire, feed: RobotFeed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    manifest = yaml.safe_load((rskill_dir(SKILL) / "rskill.yaml").read_text())
    manifest |= {"id": "long", "policy": {"backend": "constant", "options": {"row": [0.5] * 8000}}}
    (tmp_path / "long").mkdir()
    (tmp_path / "long" / "rskill.yaml").write_text(yaml.safe_dump(manifest))
    monkeypatch.setenv(SKILLS_VARIABLE, str(tmp_path))
    wire.bus.declare_token(KEYS.want_layout("long"))
    ticks = 0
    while not wire.log.messages:  # it says that it assembles once it has read it
        ticks += 1
        wire.tick(feed, ticks)
        await turns()
    assert ticks > 1  # otherwise it would have been read within the first turns


@pytest.mark.asyncio
async def test_closed_transport_listens_no_more(wire: Wire, feed: RobotFeed) -> None:
    wire.transport.close()
    wire.tick(feed, 1)
    assert wire.keys_seen() == []


def test_options_declare_the_age_of_slow_frames() -> None:
    assert checked_model("", AssemblerOptions, {"max_age_ticks": {"odom": 4}}).max_age_ticks == {
        "odom": 4
    }


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (
            {"max_age": 3},
            "max_age: unknown key, did you mean max_age_ticks? (valid: max_age_ticks)",
        ),
        (
            {"max_age_ticks": {"odom": 65}},
            "max_age_ticks.odom: Input should be less than or equal to 64, got 65",
        ),
        (
            {"max_age_ticks": {"odom": 0}},
            "max_age_ticks.odom: Input should be greater than 0, got 0",
        ),
    ],
)
def test_option_that_does_not_fit_is_refused(options: dict[str, object], problem: str) -> None:
    with pytest.raises(ConfigError) as error:
        checked_model("options", AssemblerOptions, options)
    assert str(error.value) == f"options: 1 problem(s):\n  {problem}"
