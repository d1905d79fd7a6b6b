"""One real gate with a scripted HAL and a scripted runner, over real Zenoh; a new one each time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

from bench.equipment.gate_scene import Scene
from bench.equipment.mailbox import DEADLINE_S
from bench.equipment.running_gate import ROBOT
from bench.faults.row import Shot
from fairlead.errors import RefusedError
from fairlead.messages import ActionChunk, GateState, Outcome, Verdict
from fairlead.paths import gate_config

JUDGED = "verdict"
"""How rows on one gate take their time, unless they say otherwise."""


class GateStage:
    """Opens scenes, each with a state folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self._opened = folder, 0

    @contextmanager
    def scene(
        self,
        pacing: Literal["realtime", "lockstep"] = "lockstep",
        robot: str = ROBOT,
        config: Path | None = None,
    ) -> Iterator[Scene]:
        """A gate to which nothing has been said, of the simulator's limits if no others."""
        self._opened += 1
        folder = self.folder / str(self._opened)
        scene = Scene(config or gate_config(robot, "sim"), folder, pacing, robot)
        try:
            yield scene
        finally:
            scene.close()

    @contextmanager
    def ready(self, robot: str = ROBOT, config: Path | None = None) -> Iterator[Scene]:
        """A gate in lockstep, armed, at tick 20, with the arm claimed."""
        with self.scene(robot=robot, config=config) as scene:
            scene.hal.tick = 20
            scene.ready_to_move()
            yield scene


@contextmanager
def gate_stage(folder: Path) -> Iterator[GateStage]:
    """Nothing to start: each injection has a gate of its own."""
    yield GateStage(folder)


class Stopwatch:
    """Times single answers; the row's time is the longest."""

    def __init__(self) -> None:
        self.began_ns = time.monotonic_ns()
        self.longest_ms = 0.0

    def timed(self, ask: Callable[[], object]) -> None:
        """Do one thing and remember how long its answer took."""
        began_ns = time.monotonic_ns()
        ask()
        self.note_ms((time.monotonic_ns() - began_ns) / 1e6)

    def note_ms(self, taken_ms: float) -> None:
        """A time that somebody else measured."""
        self.longest_ms = max(self.longest_ms, taken_ms)

    def shot(self, note: str = "", timed: bool = True) -> Shot:
        """The longest answer, and the stretch of time of all."""
        measured = self.longest_ms if timed else None
        return Shot(measured, self.began_ns, time.monotonic_ns(), None, note)


def refused_at_once(scene: Scene, watch: Stopwatch, chunk: ActionChunk, code: int) -> Verdict:
    """A chunk is refused with a code while the tick stands, and nothing is released.

    The time is the gate's own, from the chunk received to its answer.
    """
    verdict = scene.send(chunk)
    watch.note_ms(verdict.latency_ns / 1e6)
    assert (verdict.outcome, verdict.code) == (Outcome.REFUSED, code), verdict
    ids = {safe.verdict_id for safe in scene.safe.unread()}
    assert verdict.verdict_id not in ids, "rows of a refused chunk reached the HAL"
    return verdict


def refused(ask: Callable[[], object], *texts: str) -> None:
    """A query is refused, and the refusal says each of the texts."""
    try:
        answer = ask()
    except RefusedError as error:
        missing = [text for text in texts if text not in f"{error.reason} {error.fix}"]
        assert not missing, f"{error.reason!r} does not say {missing}"
    else:
        raise AssertionError(f"expected a refusal, got {answer}")


def counted(scene: Scene, code: str) -> int:
    """A counter of the gate now."""
    return dict(scene.status().counters).get(code, 0)


def stopped(scene: Scene) -> None:
    """Wait for the gate's stop (the third within a minute latches)."""
    scene.statuses.wait_for(lambda m: m.state in (GateState.STOPPED, GateState.LATCHED), DEADLINE_S)
