"""Which lease a HAL believes."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import msgspec
import pytest

from fairlead.errors import ConfigError
from fairlead.hal.identity import gate_limits
from fairlead.hal.lease_follower import OTHER_LIMITS, SECOND_GATE, LeaseFollower
from fairlead.messages import NO_HASH, Lease
from fairlead.paths import gate_config
from fairlead.robot.manifest import load_robot
from tests.hal.gate_messages import EPOCH, MS, SESSION, grant, lease

LEFT = "lease of an epoch already left"


@pytest.fixture
def follower() -> LeaseFollower:
    return LeaseFollower(SESSION)


def follow(follower: LeaseFollower, *leases: Lease) -> list[str]:
    return [follower.offer(message, now_ns=0) for message in leases]


def test_a_higher_lease_seq_of_the_epoch_is_followed(follower: LeaseFollower) -> None:
    assert follow(follower, lease(1, 1), lease(3, 1)) == ["", ""]


@pytest.mark.parametrize("seq", [1, 2])
def test_an_equal_or_lower_lease_seq_is_not(follower: LeaseFollower, seq: int) -> None:
    assert follow(follower, lease(2, 1), lease(seq, 1)) == ["", "lease not newer"]


@pytest.mark.parametrize(
    ("late", "at_ms", "refused"),
    [
        (lease(4, 7), 9000, "lease not newer"),  # followed, and sent once more
        (lease(4, 7, [grant(9)]), 100, SECOND_GATE),
        (lease(5, 8), 9000, "lease not newer"),  # overtaken by number 9
        (lease(5, 9), 350, "lease not newer"),
        (lease(5, 10), 100, SECOND_GATE),
        (lease(2, 7), 9000, "lease not newer"),  # overtaken by number 4
        (lease(2, 8), 100, SECOND_GATE),
    ],
)
def test_with_a_number_that_it_has_passed_the_gate_says_nothing_new_and_knows_no_later_tick(
    follower: LeaseFollower, late: Lease, at_ms: int, refused: str
) -> None:
    follower.offer(lease(4, 7), now_ns=0)
    follower.offer(lease(9, 9), now_ns=100 * MS)
    follower.offer(lease(10, 9), now_ns=350 * MS)
    assert follower.offer(late, at_ms * MS) == refused
    assert follower.newest == (late if refused == SECOND_GATE else lease(10, 9))


def test_a_lease_of_another_session_is_never_followed(follower: LeaseFollower) -> None:
    assert follow(follower, lease(1, 1, session=SESSION + 1)) == ["lease of another session"]
    assert follower.newest is None


def test_a_gate_that_follows_this_session_turns_to_no_other_but_may_start_anew(
    follower: LeaseFollower,
) -> None:
    follow(follower, lease(1, 1))
    refused = follow(follower, lease(2, 1, session=SESSION + 1), lease(1, 0, session=0))
    assert refused == [SECOND_GATE, "lease of another session"]


def test_a_new_epoch_is_followed_from_any_lease_seq(follower: LeaseFollower) -> None:
    assert follow(follower, lease(900, 1), lease(1, 1, epoch=EPOCH + 1)) == ["", ""]
    assert follower.epoch == EPOCH + 1


def test_an_epoch_once_left_is_never_followed_again(follower: LeaseFollower) -> None:
    follow(follower, lease(1, 1), lease(1, 1, epoch=EPOCH + 1))
    assert follow(follower, lease(999, 1)) == ["lease of an epoch already left"]
    assert follower.epoch == EPOCH + 1


@pytest.mark.parametrize(
    ("seq", "tick", "at_ms", "refused"),
    [
        (6, 1, 1251, SECOND_GATE),
        (6, 1, 1250, LEFT),  # may be late
        (6, 2, 1250, SECOND_GATE),  # knows more than it could
        (5, 99, 9000, LEFT),  # the one it was left at, once more
        (4, 99, 9000, LEFT),
    ],
)
def test_a_new_lease_of_an_epoch_left_long_ago_is_of_a_second_live_gate(
    follower: LeaseFollower, seq: int, tick: int, at_ms: int, refused: str
) -> None:
    follower.offer(lease(5, 1), now_ns=0)
    follower.offer(lease(1, 1, epoch=EPOCH + 1), now_ns=1000 * MS)
    assert follower.offer(lease(seq, tick), at_ms * MS) == refused
    assert follower.epoch == EPOCH + 1


def test_a_late_lease_of_an_epoch_that_was_skipped_is_not_followed(
    follower: LeaseFollower,
) -> None:
    refused = follow(
        follower, lease(1, 1), lease(1, 9, epoch=EPOCH + 2), lease(1, 5, epoch=EPOCH + 1)
    )
    assert refused == ["", "", "lease of a skipped epoch"]
    assert follow(follower, lease(2, 10, epoch=EPOCH + 2)) == [""]


def test_a_grant_of_another_epoch_than_the_rows_does_not_count(follower: LeaseFollower) -> None:
    follow(follower, lease(1, 1, [grant(9)]))
    assert follower.grant(501, EPOCH, 9) is not None
    assert follower.grant(501, EPOCH + 1, 9) is None


def test_a_gate_that_judges_by_other_limits_grants_nothing() -> None:
    limits, other = bytes([1]) * 32, bytes([2]) * 32
    follower = LeaseFollower(SESSION, limits)
    good, bad = (msgspec.structs.replace(lease(1, 1), config_hash=one) for one in (limits, other))
    assert follow(follower, bad) == [OTHER_LIMITS]
    assert follower.newest is None
    assert follow(follower, good, bad) == ["", SECOND_GATE]  # which lives beside the right one
    assert follower.offer(bad, 300 * MS) == OTHER_LIMITS  # in its place
    assert follower.newest == good


def test_the_limits_are_those_of_the_gate_file_made_of_the_robot_as_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot, file = load_robot("panda"), gate_config("panda", "sim")
    assert gate_limits(robot, "sim") == hashlib.sha256(file.read_bytes()).digest()
    made, text = tmp_path / "gate.sim.json", file.read_text(encoding="utf-8")
    monkeypatch.setattr("fairlead.hal.identity.robot_dir", lambda _: tmp_path)
    # Another host's HAL has no such file, and the gate's file is what would be made here.
    assert gate_limits(robot, "sim") == hashlib.sha256(file.read_bytes()).digest()
    digest = json.loads(text)["compiled_from"]["robot.yaml"]
    made.write_text(text.replace(digest, "0" * 64), encoding="utf-8")  # robot.yaml was edited since
    with pytest.raises(ConfigError, match="of other files than today's.*fairlead robot compile"):
        gate_limits(robot, "sim")
    made.write_text("{", encoding="utf-8")
    with pytest.raises(ConfigError, match="cannot be read"):
        gate_limits(robot, "sim")
    made.unlink()
    monkeypatch.setattr("fairlead.robot.capsules.robot_dir", lambda _: tmp_path / "none")
    assert gate_limits(robot, "sim") == NO_HASH
