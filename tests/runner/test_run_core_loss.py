"""Lockstep over a channel that loses, repeats and reorders: the run is the same run."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field

import pytest

from fairlead.messages import ActionChunk, Outcome, Verdict, decode
from fairlead_skill_runner.run_outputs import AskPolicy, Output, SendChunk
from tests.runner.scripted_robot import Story, joints, layout, rows, story, task, verdict

LAST_TICK = 80
REPEATS_ALLOWED = 400  # of one tick, before the run counts as stuck


@dataclass
class Channel:
    """Delivers each message now, later, twice or never."""

    chance: random.Random
    loss: float
    waiting: list[Callable[[], None]] = field(default_factory=list)

    def send(self, deliver: Callable[[], None]) -> None:
        draw = self.chance.random()
        if draw < self.loss:
            return
        if draw < 1.5 * self.loss:
            self.waiting.append(deliver)
            return
        deliver()
        if draw < 2.0 * self.loss:
            deliver()
        if self.waiting and self.chance.random() < 0.5:
            self.waiting.pop(self.chance.randrange(len(self.waiting)))()


@dataclass
class LossyRobot:
    """A gate that judges each chunk once, and a world that steps only on released rows."""

    run: Story
    channel: Channel
    tick: int = 1
    released_last: int = 0
    judged: dict[int, tuple[bytes, Verdict]] = field(default_factory=dict)
    verdicts: int = 0

    def play(self) -> list[bytes]:
        """The payload of every chunk that was judged, in order."""
        repeats = 0
        while self.tick < LAST_TICK:
            before = self.tick
            self.publish()
            while self.released_last >= self.tick and self.tick < LAST_TICK:
                self.tick += 1
                self.publish()
            repeats = 0 if self.tick > before else repeats + 1
            assert repeats < REPEATS_ALLOWED, f"stuck at tick {self.tick}"
        return [payload for payload, _ in self.judged.values()]

    def publish(self) -> None:
        tick, core = self.tick, self.run.core
        self.channel.send(lambda: self.take(core.on_task(task(tick), 0.0)))
        self.channel.send(lambda: self.take(core.on_joints(joints(tick), 0.0)))
        self.channel.send(lambda: self.take(core.on_layout(layout(tick), 0.0)))

    def take(self, outputs: list[Output]) -> None:
        for output in outputs:
            if isinstance(output, AskPolicy):
                seen = output.observation.tick
                answer = rows(value=seen / 100.0)
                self.take(self.run.core.on_policy(output.call, answer, 0.0))
            else:
                self.channel.send(lambda sent=output: self.judge(sent))  # type: ignore[misc]

    def judge(self, sent: SendChunk) -> None:
        chunk = decode(ActionChunk, sent.payload)
        if chunk.seq in self.judged:
            payload, known = self.judged[chunk.seq]
            assert payload == sent.payload, "a chunk is only ever sent again byte for byte"
        else:
            assert chunk.obs_tick == self.tick, "an answer is for the tick the world waits at"
            self.verdicts += 1
            # every third chunk is cut short
            cut = Outcome.TRUNCATED if chunk.seq % 3 == 0 else Outcome.RELEASED
            last = chunk.start_tick + (2 if cut == Outcome.TRUNCATED else 7)
            known = verdict(chunk, self.verdicts, cut, last=last)
            self.judged[chunk.seq] = (sent.payload, known)
            self.released_last = last
        self.channel.send(lambda: self.take(self.run.core.on_verdict(known, 0.0)))


def play(seed: int, loss: float) -> list[bytes]:
    return LossyRobot(story(lockstep=True), Channel(random.Random(seed), loss)).play()


@pytest.mark.parametrize("loss", [pytest.param(0.05, marks=pytest.mark.thorough), 0.3])
def test_every_lossy_run_is_the_undisturbed_run(loss: float) -> None:
    undisturbed = play(0, 0.0)
    assert len(undisturbed) > 10
    for seed in range(200):
        assert play(seed, loss) == undisturbed, f"seed {seed}"
