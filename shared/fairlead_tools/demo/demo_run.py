"""The demo, step by step: start, run the task, challenge the gate, write what was seen."""

from __future__ import annotations

import json
import shlex
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from fairlead.deploy.deployment import load_deployment
from fairlead.messages import GoalResult
from fairlead.operate.client import RobotClient
from fairlead.operate.goal_hearing import Progress
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.operate.runner_choice import choose_runner
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.admission import Admission
from fairlead.skill.manifest import load_skill
from fairlead_tools.demo.gate_challenge import Challenge, over_limit, replay
from fairlead_tools.record.caption import captions, refusal
from fairlead_tools.record.recorder import Recorder, Recording
from fairlead_tools.record.run_log import Run, newest_log, read_run
from fairlead_tools.record.timeline import draw_timeline, hold_names
from fairlead_tools.record.video import captioned, write_video
from fairlead_tools.supervisor.scratch import Scratch, ScratchOptions, make_scratch, scratch_robot
from fairlead_tools.writable import require_writable

FRAME_TICKS = 3  # from one frame to the next; rendering in software is slow
_CAMERA_OPTIONS = {"width": 640, "height": 480, "period_ticks": FRAME_TICKS}
DEADLINE_TICKS = 800
VIDEO, TIMELINE, SUMMARY, STATE = "demo", "timeline.png", "summary.json", "state"


@dataclass(frozen=True)
class DemoOptions:
    """What to show. out: folder for the results; its ``state`` folder is made anew.

    camera: of the simulator's, films; those of the skill are on as the deployment has them.
    """

    source: Path
    out: Path
    skill: str
    seed: int
    realtime: bool
    video: bool
    gif: bool = False
    camera: str = "overview"


@dataclass(frozen=True)
class DemoResult:
    """What happened. written: files in the out folder."""

    goal: GoalResult
    challenges: tuple[Challenge, ...]
    written: tuple[Path, ...]
    summary: dict[str, Any]


@dataclass(frozen=True)
class _Shown:
    """What the services did, before anything is written."""

    source: str
    progress: Progress
    goal_s: float
    challenges: tuple[Challenge, ...]
    recording: Recording

    @property
    def result(self) -> GoalResult:
        assert self.progress.result is not None
        return self.progress.result


def run_demo(
    wish: DemoOptions, say: Callable[[str], None], show: Callable[[Progress], None]
) -> DemoResult:
    """Run the demo.

    Raises:
        ServiceError: a service failed, or the gate released what it had to refuse.
        RefusedError, NoAnswerError: a service refused or did not answer.
    """
    scratch = _scratch(wish)
    robot = load_robot(scratch.deployment.robot)
    say(f"starting {', '.join(scratch.deployment.services)} ({scratch.deployment.pacing})")
    began_s = time.monotonic()
    with scratch_robot(scratch) as running:
        say(f"ready after {time.monotonic() - began_s:.1f} s; new episode, seed {wish.seed}")
        running.client.reset_episode(wish.seed)
        run = _run(wish, running.client, robot, say, show)
    say("services stopped; drawing")
    log = read_run(newest_log(wish.out / STATE))
    summary = _summary(wish, run, log)
    written = _write(wish, run, log, summary, robot)
    return DemoResult(run.result, run.challenges, written, summary)


def _scratch(wish: DemoOptions) -> Scratch:
    deployment = load_deployment(wish.source)
    seen = {spec.camera for spec in load_skill(wish.skill).images.values()}
    own = deployment.services[deployment.hal].options.get("cameras", [])
    cameras = [camera for camera in own if camera["name"] in seen]
    cameras += [{"name": wish.camera, **_CAMERA_OPTIONS}] if wish.video else []
    hal = {"cameras": cameras, "seed": wish.seed}
    pacing: Literal["realtime", "lockstep"] = "realtime" if wish.realtime else "lockstep"
    return make_scratch(
        wish.source, wish.out / STATE, ScratchOptions(pacing=pacing, options={"hal": hal})
    )


def _run(
    wish: DemoOptions,
    client: RobotClient,
    robot: RobotManifest,
    say: Callable[[str], None],
    show: Callable[[Progress], None],
) -> _Shown:
    skill = load_skill(wish.skill)
    client.arm()
    recorder = Recorder(client.bus, client.keys, [wish.camera] if wish.video else [])
    say(f"armed; goal: {skill.prompt}")
    began_s = time.monotonic()
    runner = choose_runner(client.deployment, wish.skill)
    goal = GoalOptions(wish.skill, deadline_ticks=DEADLINE_TICKS, runner=runner)
    progress = run_goal(client, goal, show)
    goal_s = time.monotonic() - began_s
    say("now two chunks that must not pass")
    finished = list(recorder.recording.candidate_bytes)[-1:]
    challenges = [over_limit(client, robot, skill)]
    challenges += [replay(client, sent) for sent in finished]
    for challenge in challenges:
        say(f"  sent {challenge.sent}\n  -> {challenge.reason}")
    client.disarm()
    return _Shown(runner, progress, goal_s, tuple(challenges), recorder.close())


def _summary(wish: DemoOptions, run: _Shown, log: Run) -> dict[str, Any]:
    result, ticks = run.result, run.result.last_tick - run.result.first_tick + 1
    outcomes = Counter(log.outcomes(run.source).values())
    return {
        "skill": wish.skill,
        "seed": wish.seed,
        "pacing": "realtime" if wish.realtime else "lockstep",
        "outcome": result.outcome,
        "decided_by": result.decided_by,
        "reason": f"{result.kind}: {result.detail}" if result.kind else "",
        "ticks": ticks,
        "seconds": round(run.goal_s, 2),
        "ticks_per_s": round(ticks / max(run.goal_s, 1e-9), 1),
        "policy_calls": run.progress.inferences,
        "verdicts": dict(outcomes),
        "held_ticks": hold_names(log),
        "challenges": [
            {"sent": one.sent, "code": f"G{one.verdict.code:03d}", "reason": one.reason}
            for one in run.challenges
        ],
    }


def _write(
    wish: DemoOptions, run: _Shown, log: Run, summary: dict[str, Any], robot: RobotManifest
) -> tuple[Path, ...]:
    timeline = wish.out / TIMELINE
    title = (
        f"{wish.skill}, seed {wish.seed}, {summary['pacing']}: {summary['outcome']} "
        f"after {summary['ticks']} ticks"
    )
    draw_timeline(log, robot, title, timeline)
    written = [timeline]
    written += _videos(wish, run, log, robot)
    if wish.video and not run.recording.images:
        logs = f"fairlead logs hal --state-dir {shlex.quote(str(wish.out / STATE))}"
        summary["video"] = f"no picture arrived; why is in: {logs}"
    (wish.out / SUMMARY).write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    return (*written, wish.out / SUMMARY)


def _videos(wish: DemoOptions, run: _Shown, log: Run, robot: RobotManifest) -> list[Path]:
    """What the camera saw, with the gate's verdicts below it."""
    paths = [wish.out / f"{VIDEO}.mp4", *([wish.out / f"{VIDEO}.gif"] if wish.gif else [])]
    for path in paths:
        path.unlink(missing_ok=True)
    images = run.recording.images
    if not images:
        return []
    prompt = f"goal: {load_skill(wish.skill).prompt}"
    frames_per_s = 1e9 / (robot.tick_period_ns * FRAME_TICKS)
    ends = [refusal(log, f"sent: {one.sent}", one.verdict) for one in run.challenges]
    frames = list(captioned(images, captions(log, prompt), ends, frames_per_s))
    for path in paths:
        write_video(frames, frames_per_s, path)
    return paths


def check_demo(wish: DemoOptions) -> None:
    """See that the demo can start, and that its results can be written.

    Raises:
        ConfigError: the skill cannot run on the robot, or the folder cannot be written.
    """
    robot = load_robot(load_deployment(wish.source).robot)
    Admission(load_skill(wish.skill), robot).require()
    require_writable("demo", wish.out)
