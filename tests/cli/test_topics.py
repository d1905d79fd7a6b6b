"""``fairlead topic``: which key is which message, how it reads, and a look at a real robot."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from fairlead.errors import ConfigError
from fairlead.keys import Keys
from fairlead.messages import (
    MESSAGE_TYPES,
    Acted,
    HalStatus,
    JointState,
    Outcome,
    Verdict,
    pack_floats,
)
from fairlead.paths import repo_root
from fairlead.wire.session import ZenohBus
from fairlead.wire.topics import find_topic, topics
from fairlead_tools.cli.topic import message_document, rate_of
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.cli.command import fairlead_here as fairlead

KEYS = Keys("arm_1", "lab")
SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"


@pytest.mark.parametrize("name", ["state/joints", "lab/arm_1/state/joints"])
def test_a_key_is_named_with_or_without_namespace_and_robot(name: str) -> None:
    topic = find_topic(KEYS, name)
    assert (topic.key_expr, topic.kind) == ("lab/arm_1/state/joints", JointState)


def test_one_key_of_a_family_and_the_whole_family_have_the_same_type() -> None:
    assert find_topic(KEYS, "safety/verdict/runner").kind is Verdict
    assert find_topic(KEYS, "safety/verdict/*").kind is Verdict


@pytest.mark.parametrize("name", ["state", "joints", "safety/cmd/arm", "other/arm_1/state/joints"])
def test_a_key_nobody_publishes_is_refused_with_those_there_are(name: str) -> None:
    with pytest.raises(ConfigError, match=r"topic: expected a published key.*state/joints, tf/\*"):
        find_topic(KEYS, name)


def test_no_two_topics_share_a_key_and_every_type_up_to_the_queries_has_one() -> None:
    known = topics(KEYS)
    for topic in known:
        assert [other for other in known if other.matches(topic.key_expr)] == [topic]
    published = [kind for kind in MESSAGE_TYPES if int(kind.__struct_config__.tag or 0) < 20]
    carried = {topic.kind for topic in known}
    assert set(published) <= carried


def test_a_joint_state_reads_as_numbers_names_and_hex() -> None:
    document = message_document(
        JointState(
            session=255,
            tick=7,
            episode_tick=7,
            stamp_ns=1,
            positions=pack_floats([0.5, -1.0]),
            velocities=pack_floats([0.0, 0.0]),
            efforts=pack_floats([]),
            acted=(Acted(hold=2, verdict_id=0, row=0),),
            robot_hash=bytes(31) + b"\x01",
        )
    )
    assert list(document)[:2] == ["session", "tick"]
    assert document["session"] == "00000000000000ff"
    assert (document["positions"], document["efforts"]) == ([0.5, -1.0], [])
    assert document["acted"] == [{"hold": "no_row", "verdict_id": "none", "row": 0}]
    assert document["robot_hash"] == "00" * 31 + "01"


def test_a_verdict_names_its_check_and_outcome_and_a_hal_status_keeps_its_text() -> None:
    verdict = Verdict(
        verdict_id=1, session=1, source="runner", outcome=Outcome.REFUSED, code=20, row=0,
        part="arm", axis="linear", value=5.0, limit=0.1, margin=-4.9, limit_source="robot.yaml",
        released_first=0, released_last=0, config_hash=bytes(32), epoch=0, claim_id=0, seq=0,
        latency_ns=0,
    )  # fmt: skip
    document = message_document(verdict)
    assert (document["code"], document["outcome"]) == ("G020", "refused")
    hal = HalStatus(
        session=1, robot="r", robot_hash=bytes(32), pacing="lockstep", period_ns=1, tick=1,
        episode_tick=1, state="ready", detail="", joints=(), passive_joints=(), parts=(),
        simulator_order=(), cameras=(), has_task=False, overruns=0,
    )  # fmt: skip
    assert message_document(hal)["state"] == "ready"


def test_a_rate_is_gaps_over_time_with_the_shortest_and_longest_gap() -> None:
    rates = rate_of([1.0, 1.05, 1.2])
    assert [round(value, 6) for value in rates.values()] == [3, 10.0, 50.0, 150.0]


@pytest.mark.parametrize("words", ["list", "echo state/joints", "hz state/joints"])
def test_with_nothing_running_it_says_how_to_start_one(words: str, tmp_path: Path) -> None:
    done = fairlead("topic", *words.split(), state=tmp_path)
    assert done.returncode == 1
    assert "no deployment runs on this machine; start one: fairlead up" in done.stderr


def test_a_deployment_of_which_nobody_answers_is_named(tmp_path: Path) -> None:
    scratch = make_scratch(SOURCE, tmp_path / "gone", ScratchOptions(f"gone{os.getpid()}"))
    done = fairlead("topic", "list", "-d", str(scratch.file), state=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert f"ERROR robot gone{os.getpid()}: no service seen within 3 s" in done.stderr


@pytest.fixture
def quiet_robot(tmp_path: Path) -> Iterator[Path]:
    """Deployment file of a robot that has only an alive token: nothing is published."""
    scratch = make_scratch(SOURCE, tmp_path / "quiet", ScratchOptions(f"quiet{os.getpid()}"))
    bus = ZenohBus(scratch.deployment.endpoints("hal"))
    bus.declare_token(scratch.deployment.keys.alive("hal"))
    yield scratch.file
    bus.close()


def test_a_silent_key_is_given_up_after_the_timeout(quiet_robot: Path, tmp_path: Path) -> None:
    arguments = ("topic", "echo", "state/joints", "-d", str(quiet_robot), "--timeout", "0.3")
    done = fairlead(*arguments, state=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert "topic state/joints: nothing published within 0.3 s" in done.stderr
    silent = fairlead(
        "topic", "list", "-d", str(quiet_robot), "--seconds", "0.2", "--json", state=tmp_path
    )
    listed = json.loads(silent.stdout)
    assert {row["messages"] for row in listed} == {0}
    assert {"key": "state/joints", "type": "JointState", "messages": 0} in listed
