"""A person drives an arm with a gamepad, which falls silent while its stick is deflected."""

from __future__ import annotations

import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise

from bench.equipment.live_robot import wait_for
from bench.faults.motion_rules import every_row_was_judged_for_its_tick
from bench.faults.row import MachineLateError, Shot
from bench.faults.servo_stage import PAN, ServoStage
from bench.so101_bus import ROBOT
from fairlead_tools.teleop.drive import RAMP_S
from fairlead_tools.teleop.gamepad import SILENCE_S

_KEY, _ABS, _LEFT_X, _CLUTCH = 1, 3, 0, 311
_EVENT = struct.Struct("llHHi")
SPEED, TREMBLE = 0.2, 300
SPEAKS_S = 0.05
TICK_S = ROBOT.tick_period_ns * 1e-9
LIMITS = ROBOT.profile("sim").measured[ROBOT.joint_names[PAN]]
assert LIMITS.stop_lag_s is not None
SILENT_MS = 1e3 * (SILENCE_S + RAMP_S + LIMITS.stop_lag_s + 3 * TICK_S)
"""Silence, ramp, the arm's lag; a tick each until it is noticed, judged, and measured."""
STILL_TICKS = 25
LATE = ("claim of teleop lost: the gate no longer grants it", "(protocol state_timeout_ms)")
"""Its heartbeats, or the arm's states, came too late."""


class Pad:
    """The command and its gamepad."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self.process, self._count = process, 0

    def says(self, *events: tuple[int, int, int]) -> int:
        """Events, and the kernel's end of them; CLOCK_MONOTONIC just before [ns]."""
        now_ns = time.monotonic_ns()
        assert self.process.stdin is not None
        for event in (*events, (0, 0, 0)):
            self.process.stdin.write(_EVENT.pack(0, 0, *event))
        return now_ns

    def trembles(self, share: float) -> int:
        """The stick in a hand, at about a share of its way."""
        self._count += 1
        return self.says((_ABS, _LEFT_X, int(share * 32000) + self._count % 2 * TREMBLE))

    def trembles_until(self, share: float, done: Callable[[], bool], what: str) -> int:
        """When the stick spoke last."""
        said, pause = [0], threading.Event()

        def spoken() -> bool:
            said[0] = self.trembles(share)
            pause.wait(SPEAKS_S)
            return done()

        wait_for(spoken, what)
        return said[0]


@contextmanager
def _driving(robot: ServoStage) -> Iterator[Pad]:
    """Ended by Ctrl-C, as a person does."""
    file, log = robot.robot.scratch.file, robot.robot.scratch.state_dir / "teleop.log"
    words = ["--deployment", str(file), "--part", "arm", "--speed", str(SPEED)]
    with (
        log.open("wb") as errors,
        subprocess.Popen(
            [sys.executable, "-m", "bench.faults.piped_gamepad", *words],
            bufsize=0,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=errors,
        ) as process,
    ):
        try:
            wait_for(lambda: bool(robot.client.gate_status().claims), "the arm is the person's")
            yield Pad(process)
            process.send_signal(signal.SIGINT)
            assert process.wait(20.0) == 130, log.read_text()
            assert not robot.client.gate_status().claims
        except (AssertionError, OSError) as error:
            said = log.read_text()
            if robot.others_are_busy and any(text in said for text in LATE):
                raise MachineLateError(said.splitlines()[-1]) from None
            raise AssertionError(f"{error}; the gamepad's command said: {said}") from error
        finally:
            process.kill()


def silent_gamepad(robot: ServoStage) -> Shot:
    """From the last event to the last tick that moved more than a joint at rest may seem to."""
    robot.make_ready(0)
    side = 1.0 if robot.measured[-1][1] > 0 else -1.0  # stick right: below zero
    with _driving(robot) as pad:
        pad.says((_KEY, _CLUTCH, 1))
        began_ns = time.monotonic_ns()
        injected_ns = pad.trembles_until(side, lambda: moves(robot, began_ns), "it moves")
        wait_for(lambda: rests(robot, injected_ns), "it comes to rest")
        rested_ns = last_motion_ns(robot, injected_ns)
        again_ns = time.monotonic_ns()
        pad.trembles_until(side, lambda: moves(robot, again_ns), "it moves again")
    every_row_was_judged_for_its_tick(robot)
    rest_ms = (rested_ns - injected_ns) / 1e6
    assert rest_ms > 1e3 * SILENCE_S - 1e3 * TICK_S, f"at rest after {rest_ms:.0f} ms"
    return Shot(rest_ms, injected_ns, rested_ns, robot.tick_ms(injected_ns))


def _motion(robot: ServoStage, since_ns: int) -> list[tuple[int, bool]]:
    """Of each tick: when it was measured, and whether the arm had moved in it."""
    measured = [one for one in list(robot.measured) if one[0] >= since_ns]
    least = LIMITS.standstill_per_s * TICK_S
    return [(stamp, abs(now - before) >= least) for (_, before), (stamp, now) in pairwise(measured)]


def moves(robot: ServoStage, since_ns: int) -> bool:
    """Whether the arm moves, by the newest of the ticks since then."""
    newest = _motion(robot, since_ns)[-10:]
    return len(newest) == 10 and all(moved for _, moved in newest)


def rests(robot: ServoStage, since_ns: int) -> bool:
    """Whether the arm has stood still in the newest of the ticks since then."""
    newest = _motion(robot, since_ns)[-STILL_TICKS:]
    return len(newest) == STILL_TICKS and not any(moved for _, moved in newest)


def last_motion_ns(robot: ServoStage, since_ns: int) -> int:
    """When the arm moved last; ``since_ns`` if it has not moved since."""
    return max((stamp for stamp, moved in _motion(robot, since_ns) if moved), default=since_ns)
