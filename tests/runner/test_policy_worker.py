"""The policy worker with real processes: hangs, crashes and garbage become typed errors."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import AsyncIterator

import numpy as np
import pytest
import pytest_asyncio

from fairlead.errors import PolicyError
from fairlead.paths import repo_root
from fairlead.plugins import POLICIES, Plugin
from fairlead.policy import Done, Executed, Failed, Judged, Observation
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_skill_runner.policy_worker import PolicyWorker
from tests.client.turns import until

ORACLE = load_skill("oracle-counter-to-cabinet")


def within(inference_timeout_s: float) -> SkillManifest:
    """The skill, with a policy that may take so long."""
    changed = ORACLE.model_dump(mode="json") | {"inference_timeout_s": inference_timeout_s}
    return SkillManifest.model_validate(changed)


SKILL = within(60.0)
SEEN = Observation(tick=41, state=np.arange(0.5, 30.0), prompt="pick")

ROWS = "policy worker: inference failed: policy: expected actions as floats [1 to 8, 12], "

pytestmark = [pytest.mark.processes, pytest.mark.asyncio]


@pytest.fixture(autouse=True)
def _worker_finds_this_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(repo_root()))


@pytest_asyncio.fixture
async def workers() -> AsyncIterator[list[PolicyWorker]]:
    started: list[PolicyWorker] = []
    yield started
    for worker in started:
        await worker.close()


def broken(workers: list[PolicyWorker], name: str, skill: SkillManifest = SKILL) -> PolicyWorker:
    where = f"tests.runner.broken_policies:{name}"
    policy = Plugin("policy backend", name, where, "the tests")
    workers.append(PolicyWorker(policy, skill, {}))
    return workers[-1]


async def refusal(worker: PolicyWorker) -> str:
    with pytest.raises(PolicyError) as caught:
        await worker.infer(SEEN)
    return str(caught.value)


async def test_the_policy_sees_the_whole_observation(workers: list[PolicyWorker]) -> None:
    worker = broken(workers, "Echo")
    await worker.load()
    await worker.reset()
    image = np.zeros((2, 1, 3), dtype=np.uint8)
    image[1, 0, 2] = 200
    executed = {"arm": Executed("refused", None), "base": Executed("", 33)}
    judged = Judged(33, "truncated", "G020", "G020 limit: ...", 39)
    seen = Observation(SEEN.tick, SEEN.state, SEEN.prompt, {"eye": image}, executed, judged)
    actions = await worker.infer(seen)
    assert isinstance(actions, np.ndarray)
    assert actions.dtype == np.float32
    assert actions.shape == (8, 12)
    np.testing.assert_array_equal(actions[0, :5], [41, 1.5, 4, 200, 1])
    assert executed["base"].answer_tick == actions[0, 5] and judged.last_tick == actions[0, 6]
    pid = worker.pid
    await worker.load()
    assert worker.pid == pid, "loading again keeps a worker that lives"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("Raises", "policy worker: inference failed: ValueError: no such token"),
        ("RaisesUnheard", "policy worker: inference failed: ValueError: no such token"),
        ("Exits", "policy worker: inference failed: SystemExit: no token"),
        ("TooNarrow", ROWS + "got float32 [8, 11]"),
        ("TooLong", ROWS + "got float32 [16, 12]"),
        ("Flat", ROWS + "got float32 [12]"),
        ("WholeNumbers", ROWS + "got int64 [8, 12]"),
        ("Objects", ROWS + "got object [8, 12]"),
        ("Forgets", ROWS + "got NoneType"),
        ("Wraps", ROWS + "got dict"),
        (
            "MasksRows",
            "policy worker: inference failed: policy: expected actions without masked numbers, "
            "got a masked array",
        ),
        ("Nested", "policy worker: inference failed: ValueError: setting an array element"),
        ("Huge", ROWS + "got float32 [50000000, 12]"),
        ("Recurses", "policy worker: inference failed: RecursionError: maximum recursion depth"),
        ("Spells", "policy worker: inference failed: ValueError: no \\udc80"),
        (
            "Wordless",
            "policy worker: inference failed: FaultError: its text cannot be had: ValueError",
        ),
        (
            "NotANumber",
            "policy worker: inference failed: policy: expected actions as finite "
            "float32 numbers, got nan in row 2 dimension 3",
        ),
        ("TalksNonsense", "policy worker: not a reply: "),
        ("TalksDeeply", "policy worker: not a reply: "),
        (
            "TalksMuch",
            "policy worker: inference: expected a reply of at most 1000384 bytes, got 4000000000",
        ),
        ("TalksOfRows", "policy worker: not rows of float32: "),
        (
            "TalksOfOtherRows",
            "policy worker: expected actions as floats [1 to 8, 12], got float32 [0]",
        ),
        (
            "TalksOfNoEnd",
            "policy worker: not an end: policy: Failed: kind: expected 1 to 64 of a-z",
        ),
        ("HangsUp", "policy worker: inference: the process ended with status "),
    ],
)
async def test_a_policy_that_fails_or_answers_garbage_is_a_typed_error(
    workers: list[PolicyWorker], name: str, text: str
) -> None:
    worker = broken(workers, name)
    await worker.load()
    assert (await refusal(worker)).startswith(text)
    assert worker.pid is None, "what it says later is no answer"


async def test_rows_of_float64_or_lists_are_rounded_to_float32_as_those_of_servers_are(
    workers: list[PolicyWorker],
) -> None:
    for name, rows in [("Doubles", 8), ("Lists", 2)]:
        worker = broken(workers, name)
        await worker.load()
        actions = await worker.infer(SEEN)
        assert isinstance(actions, np.ndarray) and actions.dtype == np.float32
        np.testing.assert_array_equal(actions, np.full((rows, 12), np.float32(0.1)))


async def test_a_policy_that_hangs_is_ended_and_its_late_answer_cannot_come(
    workers: list[PolicyWorker],
) -> None:
    worker = broken(workers, "Hangs", within(0.3))
    await worker.load()
    pid = worker.pid
    assert pid is not None
    assert await refusal(worker) == "policy worker: inference took longer than 0.3 s"
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    assert await refusal(worker) == "policy worker: inference asked, but no policy is loaded"


async def test_a_policy_whose_process_dies_is_a_typed_error_and_can_be_loaded_again(
    workers: list[PolicyWorker],
) -> None:
    worker = broken(workers, "Dies")
    await worker.load()
    assert await refusal(worker) == "policy worker: inference: the process ended with status 7"
    await worker.load()
    assert worker.pid is not None


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGPIPE, signal.SIGSEGV])
async def test_of_a_policy_that_a_signal_ends_the_signal_is_told_and_nothing_printed(
    workers: list[PolicyWorker], capfd: pytest.CaptureFixture[str], number: signal.Signals
) -> None:
    worker = broken(workers, "DiesOfSignal")
    await worker.load()
    with pytest.raises(PolicyError, match=f"the process ended with status -{int(number)}$"):
        await worker.infer(Observation(tick=number, state=SEEN.state, prompt=""))
    assert capfd.readouterr() == ("", "")


async def test_a_policy_whose_process_dies_is_noticed_though_one_that_it_started_lives_on(
    workers: list[PolicyWorker],
) -> None:
    worker = broken(workers, "DiesAfterFork", within(10.0))
    await worker.load()
    assert await refusal(worker) == "policy worker: inference: the process ended with status 7"


async def test_a_policy_that_cannot_be_loaded_says_why(workers: list[PolicyWorker]) -> None:
    with pytest.raises(PolicyError) as caught:
        await broken(workers, "CannotLoad").load()
    assert str(caught.value) == ("policy worker: loading failed: FileNotFoundError: weights.bin")
    with pytest.raises(PolicyError) as caught:
        await broken(workers, "Absent").load()
    assert str(caught.value).startswith(
        "policy worker: loading failed: policy backend 'Absent' of the tests: "
        "tests.runner.broken_policies:Absent cannot be imported: AttributeError: module "
        "'tests.runner.broken_policies' has no attribute 'Absent'"
    )


async def test_options_that_do_not_fit_say_so(workers: list[PolicyWorker]) -> None:
    worker = PolicyWorker(POLICIES.find("constant"), SKILL, {"row": [0.0] * 11})
    workers.append(worker)
    with pytest.raises(PolicyError) as caught:
        await worker.load()
    assert str(caught.value) == (
        "policy worker: loading failed: constant policy: expected a row of 12, got 11"
    )


async def test_a_load_that_is_cancelled_ends_its_process_at_once_and_another_can_begin(
    workers: list[PolicyWorker],
) -> None:
    worker = broken(workers, "NeverLoads")
    loading = asyncio.create_task(worker.load())
    await until(lambda: worker.pid is not None)
    pid = worker.pid
    assert pid is not None
    loading.cancel()
    with pytest.raises(asyncio.CancelledError):
        await loading
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    with pytest.raises(PolicyError, match="loading took longer than 0.1 s"):
        await worker.load(timeout_s=0.1)


async def test_who_asks_while_a_policy_loads_waits_for_the_same_process(
    workers: list[PolicyWorker],
) -> None:
    worker = broken(workers, "Echo")
    loads = [asyncio.create_task(worker.load()) for _ in range(3)]
    await until(lambda: worker.pid)
    started = worker.pid
    await asyncio.gather(*loads)
    assert worker.pid == started


@pytest.mark.parametrize("how", ["one gives up", "the worker is closed"])
async def test_a_load_that_hangs_is_ended_for_all_who_wait(
    workers: list[PolicyWorker], how: str
) -> None:
    worker = broken(workers, "NeverLoads")
    loads = [asyncio.create_task(worker.load()) for _ in range(3)]
    await until(lambda: worker.pid)
    if how == "one gives up":
        loads[0].cancel()
    else:
        await worker.close()
    ends = await asyncio.gather(*loads, return_exceptions=True)
    assert [str(end) for end in ends[1:]] == ["policy worker: loading was ended"] * 2
    assert worker.pid is None


async def test_the_process_ends_with_its_worker(workers: list[PolicyWorker]) -> None:
    worker = broken(workers, "Echo")
    await worker.load()
    pid = worker.pid
    assert pid is not None
    await worker.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.parametrize(
    ("policy", "end"),
    [
        ("SaysDone", Done("the drawer is shut")),
        ("GivesUp", Failed("object_lost", "nothing is in the hand")),
    ],
)
async def test_a_policy_may_end_its_goal_and_is_asked_again_in_the_next(
    workers: list[PolicyWorker], policy: str, end: Done | Failed
) -> None:
    worker = broken(workers, policy)
    await worker.load()
    pid = worker.pid
    assert await worker.infer(SEEN) == end
    await worker.reset()
    assert await worker.infer(SEEN) == end
    assert worker.pid == pid


async def test_a_reason_that_is_not_one_word_is_an_error_of_the_policy(
    workers: list[PolicyWorker],
) -> None:
    worker = broken(workers, "GivesUpBadly")
    await worker.load()
    assert await refusal(worker) == (
        "policy worker: inference failed: policy: Failed: kind: expected 1 to 64 of a-z 0-9 _ "
        "starting with a letter, got 'Object lost!'"
    )
