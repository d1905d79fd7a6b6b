"""The demo, step by step: start, run the task, challenge the gate, write what was seen."""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fairlead.demo.gate_challenge import Challenge, GateChallenge
from fairlead.errors import ConfigError
from fairlead.goal_run import GoalWish, run_goal
from fairlead.goal_watch import Progress
from fairlead.messages import GoalResult, Outcome
from fairlead.record.film import write_film
from fairlead.record.recorder import Recorder, Recording
from fairlead.record.timeline import draw_timeline, hold_names
from fairlead.robot import RobotManifest, load_robot
from fairlead.scratch_robot import scratch_robot
from fairlead.skill import load_skill
from fairlead.supervisor.scratch import ScratchOptions, make_scratch

CAMERA = "overview"
FRAME_TICKS = 3  # from one frame to the next; rendering in software is slow
_CAMERA_OPTIONS = {"name": CAMERA, "width": 480, "height": 360, "period_ticks": FRAME_TICKS}
DEADLINE_TICKS = 800
FILM, TIMELINE, SUMMARY, STATE = "demo.mp4", "timeline.png", "summary.json", "state"


@dataclass(frozen=True)
class DemoWish:
    """What to show. out: folder for the results; its ``state`` folder is made anew."""

    source: Path
    out: Path
    skill: str
    seed: int
    realtime: bool
    video: bool


@dataclass(frozen=True)
class DemoResult:
    """What happened. written: files in the out folder."""

    goal: GoalResult
    challenges: tuple[Challenge, ...]
    written: tuple[Path, ...]
    summary: dict[str, Any]


def run_demo(
    wish: DemoWish, say: Callable[[str], None], show: Callable[[Progress], None]
) -> DemoResult:
    """Run the demo.

    Raises:
        ServiceError: a service failed, or the gate released what it had to refuse.
        RefusedError, NoAnswerError: a service refused or did not answer.
    """
    began_s = time.monotonic()
    robot_options: dict[str, dict[str, Any]] = {
        "hal": {"cameras": [_CAMERA_OPTIONS] if wish.video else [], "seed": wish.seed}
    }
    scratch = make_scratch(
        wish.source,
        wish.out / STATE,
        ScratchOptions("", "realtime" if wish.realtime else "lockstep", robot_options),
    )
    skill, robot = load_skill(wish.skill), load_robot(scratch.deployment.robot)
    say(f"starting {', '.join(scratch.deployment.services)} ({scratch.deployment.pacing})")
    with scratch_robot(scratch) as running:
        client = running.client
        say(f"ready after {time.monotonic() - began_s:.1f} s; new episode, seed {wish.seed}")
        client.reset_episode(wish.seed)
        client.arm()
        recorder = Recorder(client.bus, client.keys, [CAMERA] if wish.video else [])
        say(f"armed; goal: {skill.prompt}")
        goal_began_s = time.monotonic()
        progress = run_goal(client, GoalWish(wish.skill, deadline_ticks=DEADLINE_TICKS), show)
        goal_s = time.monotonic() - goal_began_s
        recording = recorder.close()
        challenges = _challenge(GateChallenge(client, robot, skill), recording, say)
        client.disarm()
    assert progress.result is not None
    summary = _summary(wish, progress, recording, challenges, goal_s)
    say("services stopped; drawing")
    written = _write(wish, recording, summary, robot)
    return DemoResult(progress.result, challenges, written, summary)


def _challenge(
    gate: GateChallenge, recording: Recording, say: Callable[[str], None]
) -> tuple[Challenge, ...]:
    say("now two chunks that must not pass")
    challenges = [gate.over_limit()]
    if recording.candidate_bytes:
        challenges.append(gate.replay(recording.candidate_bytes[-1]))
    for challenge in challenges:
        say(f"  sent {challenge.sent}\n  -> {challenge.reason}")
    return tuple(challenges)


def _summary(
    wish: DemoWish,
    progress: Progress,
    recording: Recording,
    challenges: tuple[Challenge, ...],
    goal_s: float,
) -> dict[str, Any]:
    result = progress.result
    assert result is not None
    ticks = result.last_tick - result.first_tick + 1
    outcomes = Counter(Outcome(v.outcome).name.lower() for v in recording.verdicts)
    codes = Counter(f"G{v.code:03d}" for v in recording.verdicts if v.code)
    return {
        "skill": wish.skill,
        "seed": wish.seed,
        "pacing": "realtime" if wish.realtime else "lockstep",
        "outcome": result.outcome,
        "decided_by": result.decided_by,
        "reason": f"{result.kind}: {result.detail}" if result.kind else "",
        "ticks": ticks,
        "seconds": round(goal_s, 2),
        "ticks_per_s": round(ticks / max(goal_s, 1e-9), 1),
        "policy_calls": progress.inferences,
        "verdicts": dict(outcomes),
        "verdict_codes": dict(codes),
        "held_ticks": hold_names(recording),
        "challenges": [asdict(challenge) for challenge in challenges],
    }


def _write(
    wish: DemoWish, recording: Recording, summary: dict[str, Any], robot: RobotManifest
) -> tuple[Path, ...]:
    timeline = wish.out / TIMELINE
    title = (
        f"{wish.skill}, seed {wish.seed}, {summary['pacing']}: {summary['outcome']} "
        f"after {summary['ticks']} ticks"
    )
    draw_timeline(recording, robot, title, timeline)
    written = [timeline]
    film = wish.out / FILM
    film.unlink(missing_ok=True)
    if recording.images:
        write_film(
            recording.images, 1e9 / (robot.tick_period_ns * int(CAMERA["period_ticks"])), film
        )
        written.append(film)
    elif wish.video:
        summary["film"] = "no frame arrived; rendering is off, see the hal's log"
    (wish.out / SUMMARY).write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    return (*written, wish.out / SUMMARY)


def check_out_folder(out: Path) -> None:
    """Make the folder for the results.

    Raises:
        ConfigError: it cannot be made.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(f"demo: cannot make {out}: {error.strerror}") from None
