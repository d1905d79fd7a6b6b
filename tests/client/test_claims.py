"""Parts held by a program: kept alive, given back in whatever way it ends, and lost by name."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

from fairlead import PartClaim, Robot
from fairlead.errors import (
    ChunkRefusedError,
    ClaimLostError,
    ConfigError,
    LayoutError,
    NoAnswerError,
    RefusedError,
)
from fairlead.messages import (
    NO_HASH,
    ActionChunk,
    ActionPart,
    GateState,
    Outcome,
    Verdict,
    decode,
    floats,
)
from fairlead.modes import ControlMode
from fairlead.operate import part_claim
from fairlead.wire.bus import Sample
from tests.client.scripted_robot import CLAIM_ID, DEPLOYMENT, EPOCH, SESSION, ScriptedRobot
from tests.client.turns import turns, until

pytestmark = pytest.mark.asyncio
STILL = [[0.0] * 6] * 4


@pytest_asyncio.fixture
async def claim(robot: Robot, scripted: ScriptedRobot) -> AsyncIterator[PartClaim]:
    async with robot.claim(["base"], source="planner", task="drive") as claim:
        scripted.lease()
        yield claim


def answer(scripted: ScriptedRobot, outcome: Outcome, code: int = 0) -> list[ActionChunk]:
    """Have the gate answer every chunk; the chunks as they come."""
    chunks: list[ActionChunk] = []

    def on_chunk(sample: Sample) -> None:
        chunk = decode(ActionChunk, sample.payload)
        chunks.append(chunk)
        verdict = Verdict(
            verdict_id=1, session=SESSION, epoch=EPOCH, claim_id=CLAIM_ID, source="planner",
            seq=chunk.seq, outcome=outcome, code=code, row=0, part="base", axis="x", value=0.5,
            limit=0.4, margin=-0.1, limit_source="robot.yaml", released_first=0, released_last=0,
            config_hash=NO_HASH, latency_ns=1,
        )  # fmt: skip
        scripted.put(DEPLOYMENT.keys.verdict("planner"), verdict)

    scripted.bus.subscribe(DEPLOYMENT.keys.candidate("planner"), on_chunk)
    return chunks


def base_rows(claim: PartClaim) -> ActionPart:
    return claim.rows("base", ControlMode.BODY_TWIST, STILL)


async def test_a_claim_beats_until_it_is_given_back(robot: Robot, scripted: ScriptedRobot) -> None:
    async with robot.claim(["base"], source="planner", task="drive"):
        [asked] = scripted.claims
        assert (asked.parts, asked.skill, asked.source) == (("base",), "drive", "planner")
        await until(lambda: scripted.beats >= 2)
    assert scripted.released == [CLAIM_ID]
    beats = scripted.beats
    await asyncio.wait({asyncio.ensure_future(until(lambda: scripted.beats > beats))}, timeout=0.2)
    assert scripted.beats == beats


async def test_a_claim_is_given_back_when_its_task_is_cancelled(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    async def hold() -> None:
        async with robot.claim(["base"], source="planner") as claim:
            await claim.next_tick()

    task = asyncio.ensure_future(hold())
    await until(lambda: scripted.beats > 0)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert scripted.released == [CLAIM_ID]


async def test_cancelled_while_it_is_granted_a_claim_is_given_back_at_once(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    scripted.answers_late = True

    async def hold() -> None:
        async with robot.claim(["base"], source="planner"):
            raise AssertionError("never held")

    task = asyncio.ensure_future(hold())
    await until(lambda: scripted.waiting)
    task.cancel()
    scripted.answer()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert (scripted.released, scripted.beats) == ([CLAIM_ID], 0)


async def test_closed_while_it_is_granted_a_claim_is_given_back_at_once(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    scripted.answers_late = True
    claim = robot.claim(["base"], source="planner")
    taking = asyncio.ensure_future(claim.__aenter__())
    await until(lambda: scripted.waiting)
    closing = asyncio.ensure_future(robot.close())
    await turns()
    scripted.answer()
    await closing
    with pytest.raises(ClaimLostError, match="^claim of planner lost: given back while it was tak"):
        await taking
    assert (scripted.released, scripted.beats) == ([CLAIM_ID], 0)


async def test_a_tick_is_told_whole_and_one_that_came_in_part_when_it_comes_again(
    claim: PartClaim, scripted: ScriptedRobot
) -> None:
    scripted.transforms(0, 0.3, static=True)
    scripted.joints(1)  # its transforms were lost
    with pytest.raises(NoAnswerError, match=r"^planner: no joint state within 0\.01 s$"):
        await claim.next_tick(0.01)
    scripted.transforms(1, 0.5)
    scripted.joints(1)
    tick = await claim.next_tick()
    assert (tick.number, tick.planar_pose("odom", "base_link")) == (1, (0.5, 0.0, 0.0))
    assert tick.planar_pose("base_link", "camera") == (0.3, 0.0, 0.0)
    with pytest.raises(LayoutError) as caught:
        tick.planar_pose("map", "base_link")
    assert str(caught.value) == (
        "tick 1: no transform map -> base_link (valid: base_link -> camera, odom -> base_link)"
    )


async def test_rows_are_sent_for_the_tick_they_cite_and_the_gates_word_is_awaited(
    claim: PartClaim, scripted: ScriptedRobot
) -> None:
    chunks = answer(scripted, Outcome.RELEASED)
    assert (await claim.send(8, base_rows(claim))).outcome == Outcome.RELEASED
    await claim.send(9, base_rows(claim))
    assert [(chunk.seq, chunk.start_tick, chunk.horizon) for chunk in chunks] == [
        (1, 8, 4),
        (2, 9, 4),
    ]


async def test_rows_are_sent_again_with_each_tick_that_brings_no_verdict(
    claim: PartClaim, scripted: ScriptedRobot
) -> None:
    sending = asyncio.ensure_future(claim.send(1, base_rows(claim)))
    await until(lambda: claim._payload)
    chunks = answer(scripted, Outcome.RELEASED)  # the first copy was lost
    scripted.joints(1)
    assert (await sending).seq == 1
    assert len(chunks) == 1


async def test_refused_rows_are_an_error_with_the_verdict(
    claim: PartClaim, scripted: ScriptedRobot
) -> None:
    answer(scripted, Outcome.REFUSED, 20)
    with pytest.raises(ChunkRefusedError) as caught:
        await claim.send(1, base_rows(claim))
    assert str(caught.value) == (
        "safety refused: G020 limit: chunk 1 refused at row 0, base x: 0.5, limit 0.4\n"
        "  try: fairlead why"
    )
    assert caught.value.verdict.code == 20


async def test_a_claim_that_is_lost_is_said_at_once_and_not_given_back(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    async with robot.claim(["base"], source="planner") as claim:
        scripted.lease()
        waiting = asyncio.ensure_future(claim.next_tick())
        await until(lambda: scripted.beats > 0)
        scripted.lease(granted=False, state=GateState.STOPPED)
        with pytest.raises(ClaimLostError, match="^claim of planner lost: the gate is stopped$"):
            await waiting
        with pytest.raises(ClaimLostError):
            await claim.send(1, base_rows(claim))
    assert scripted.released == []


async def test_a_gate_that_grants_nothing_more_to_hear_of_is_a_claim_lost(
    claim: PartClaim, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(part_claim, "LEASE_SILENCE_S", 0.0)
    with pytest.raises(ClaimLostError, match="^claim of planner lost: no lease for 0 s; is the "):
        await claim.next_tick(0.01)


async def test_a_program_that_was_paused_keeps_a_claim_that_the_next_lease_grants(
    claim: PartClaim, scripted: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = time.monotonic
    monkeypatch.setattr(time, "monotonic", lambda: now_s() + 60.0)
    scripted.transforms(5, 0.5)
    scripted.joints(5)
    waiting = asyncio.ensure_future(claim.next_tick())
    await turns()
    scripted.lease()
    assert (await waiting).number == 5


async def test_what_cannot_be_claimed_is_said_before_anybody_is_asked(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    with pytest.raises(ConfigError, match=r"expected a part to claim, got 'bass' \(valid: arm, "):
        robot.claim(["bass"], source="planner")
    with pytest.raises(ConfigError, match=r"expected a list of parts, got \[\]"):
        robot.claim([], source="planner")
    with pytest.raises(ConfigError, match="source that is none of its services, got 'runner'"):
        robot.claim(["base"], source="runner")
    with pytest.raises(ConfigError, match="source: expected 1 to 64 of"):
        robot.claim(["base"], source="my planner")
    assert scripted.claims == []


async def test_a_claim_that_the_gate_does_not_grant_is_refused_in_its_words(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    scripted.refuses = "part base is held by another"
    with pytest.raises(RefusedError, match="^safety refused: part base is held by another$"):
        async with robot.claim(["base"], source="planner"):
            raise AssertionError("never held")


@pytest.mark.parametrize(
    ("part", "mode", "rows", "options", "problem"),
    [
        ("bass", "body_twist", STILL, {}, r"a part, got 'bass' \(valid: arm, gripper, base"),
        ("base", "cartesian_pose", STILL, {}, r"modes, got cartesian_pose \(valid: joint_vel"),
        ("base", "body_twist", [[1.0] * 3], {}, r"rows \[H >= 1, 6\] of .*, got \[1, 3\]"),
        ("base", "body_twist", [], {}, r"got \[0\]"),
        ("base", "body_twist", [[1.0], [1.0, 2.0]], {}, "got rows of other things"),
        ("base", "body_twist", STILL, {"frame": "odom"}, "no frame for body_twist, got 'odom'"),
        ("base", "body_twist", STILL, {"joints": ("x",)}, "no joints for body_twist, got 'x'"),
        ("arm", "cartesian_delta", STILL, {}, "the frame of its cartesian_delta, got none"),
        ("base", "joint_velocity", [[0.0] * 3], {"joints": ("x",)}, "joint_velocity, got 'x'"),
        ("base", "joint_velocity", STILL, {}, r"rows \[H >= 1, 3\] of numbers"),
    ],
)
async def test_rows_that_do_not_fit_are_refused_where_they_are_made(
    claim: PartClaim, part: str, mode: str, rows: object, options: dict[str, object], problem: str
) -> None:
    with pytest.raises(ConfigError, match=problem):
        claim.rows(part, ControlMode[mode.upper()], rows, **options)  # type: ignore[arg-type]


async def test_joint_rows_stand_in_the_columns_of_their_joints(robot: Robot) -> None:
    base = robot.manifest.parts[robot.manifest.part_names.index("base")]
    first, second = base.joints[1], base.joints[0]
    claim = robot.claim(["base"], source="planner")
    made = claim.rows("base", ControlMode.JOINT_VELOCITY, [[1.0, 2.0]], joints=(first, second))
    wire = floats(made.values, robot.manifest.n_dof)
    columns = [robot.manifest.joint_names.index(name) for name in (first, second)]
    assert list(wire[0, columns]) == [1.0, 2.0]
    assert (made.active, wire.sum()) == (tuple(sorted(columns)), 3.0)


async def test_parts_of_one_chunk_have_as_many_rows(claim: PartClaim) -> None:
    one, two = base_rows(claim), claim.rows("base", ControlMode.BODY_TWIST, STILL[:2])
    with pytest.raises(ConfigError, match="expected parts of one number of rows, got 2, 4$"):
        await claim.send(1, one, two)
    with pytest.raises(ConfigError, match="got no parts$"):
        await claim.send(1)
