"""The light robot in realtime over a bad network, with policies that take their time."""

from __future__ import annotations

import os
import random
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import yaml

from bench.equipment.live_robot import wait_for
from bench.equipment.motion_log import MotionLine
from bench.equipment.turning import BASE, ROBOT, TurningBase
from bench.faults.live_stage import SKILL, Changes
from bench.faults.machine_stage import copy_tree, in_tree
from bench.faults.proxy import forward, lossy
from bench.faults.routed_stage import RoutedStage, routed_stage
from bench.faults.row import MachineLateError
from fairlead.messages import Hold, Verdict, decode
from fairlead.operate.goal_hearing import Progress
from fairlead.paths import repo_root
from fairlead.wire.bus import Sample

POLICY = repo_root() / "bench" / "chunk_async" / "late_policy.py"
HORIZON, LONG_HORIZON, BLEND_TICKS = 16, 32, 8
TICK_S = 0.05
JITTER, LOST, OVERTAKEN = 0.2, 0.01, 0.01
WARM = 3
"""The answer from which on it counts: the first is the cold start, the second asked with that."""
AGE_MAX_TICKS = 20
"""Of the gate: answers to older observations are refused."""


@dataclass(frozen=True)
class Way:
    """How many rows a skill's answers have, and how their seams are made. name: for people."""

    name: str
    blend_ticks: int = 0
    continues: bool = False
    horizon: int = HORIZON


BLENDED = Way("blended", blend_ticks=BLEND_TICKS)
LONG = Way("blended", blend_ticks=BLEND_TICKS, horizon=LONG_HORIZON)
PREFIX = Way("prefix", continues=True)


class AsyncStage(RoutedStage):
    """base: what it was told and did. seqs: the number of an answer, by verdict.

    ways: ticks from a state to a question, and from an answer to the tick in which it acts.
    """

    folder: Path
    ways: tuple[list[float], list[float]]
    base: TurningBase
    seqs: dict[int, int]

    def listen(self, folder: Path) -> None:
        """Hear what the gate releases and says of it."""
        self.folder, self.seqs, self.ways = folder, {}, ([], [])
        self.base = TurningBase(self.client.bus, self.client.keys)
        self.client.bus.subscribe(self.client.keys.every_verdict, self._on_verdict)

    def _on_verdict(self, sample: Sample) -> None:
        verdict = decode(Verdict, sample.payload)
        self.seqs[verdict.verdict_id] = verdict.seq

    def start_late(self, skill: str) -> Future[Progress]:
        """A goal of another skill, once an answer acts that was asked for while rows acted.

        Raises:
            MachineLateError: the goal ended before that.
        """
        self.ready_to_move()
        self.base.clear()
        self.seqs.clear()
        self._skill, began_ns = skill, time.monotonic_ns()
        goal = self.start_goal()

        def is_warm() -> bool:
            lines = self.motion.since(began_ns)
            return goal.done() or any((self.seq(line) or 0) >= WARM for line in lines)

        wait_for(is_warm, "a warm policy's rows act")
        if goal.done():
            raise MachineLateError(f"the goal ended before it began: {goal.result().result}")
        return goal

    def seq(self, line: MotionLine) -> int | None:
        """Which answer's row the base executed; None: it held, or the verdict was not heard."""
        return self.seqs.get(line.rows[BASE][0]) if line.holds[BASE] == Hold.NONE else None

    def bad_network(self, seed: int) -> int:
        """Lose and reorder the runner's messages until `good_network`; when [ns]."""
        proxy, rng = self.proxies["runner"], random.Random(seed)
        proxy.set("up", lossy(LOST, OVERTAKEN, rng), new_links=forward)
        return proxy.set("down", lossy(LOST, OVERTAKEN, rng), new_links=forward)

    def add_skill(self, latency_s: float, way: Way, seed: int) -> tuple[str, Path]:
        """A skill with such a policy; its id, and where the policy writes its answers."""
        name = f"late-{latency_s * 1e3:.0f}-{way.name}-{way.horizon}-{seed}"
        skills = self.folder / "skills"
        manifest = yaml.safe_load((skills / SKILL / "rskill.yaml").read_text(encoding="utf-8"))
        log = self.folder / f"{name}.jsonl"
        options = {
            "latency_s": latency_s, "jitter": JITTER, "seed": seed, "continues": way.continues,
            "log": str(log),
        }  # fmt: skip
        manifest |= {
            "id": name, "horizon": way.horizon, "execute_steps": way.horizon * 3 // 4,
            "age_max_ticks": AGE_MAX_TICKS,
            "policy": {
                "backend": "python",
                "options": {
                    "file": POLICY.name, "class": "LatePolicy", "options": options, "probe": False,
                },
            },
        }  # fmt: skip
        if way.blend_ticks:
            manifest["seam"] = {"blend_ticks": way.blend_ticks}
        log.unlink(missing_ok=True)
        (skills / name).mkdir(exist_ok=True)
        (skills / name / "rskill.yaml").write_text(yaml.safe_dump(manifest), encoding="utf-8")
        shutil.copy(POLICY, skills / name)
        return name, log


def patient_robot(tree: Path) -> None:
    """A checkout with a robot whose answers may be as late as these are."""
    copy_tree(tree)
    file = tree / "robots" / ROBOT.id / "robot.yaml"
    text = file.read_text(encoding="utf-8")
    file.write_text(re.sub(r"\bage_max_ticks: \d+", f"age_max_ticks: {AGE_MAX_TICKS}", text))
    words = [str(Path(sys.executable).with_name("fairlead")), "robot", "compile", ROBOT.id]
    environment = os.environ | {"FAIRLEAD_ROOT": str(tree)}
    subprocess.run(words, env=environment, check=True, stdout=subprocess.DEVNULL, timeout=120)


@contextmanager
def async_stage(folder: Path) -> Iterator[AsyncStage]:
    """Router, proxies and services, all started."""
    tree = folder / "tree"
    folder.mkdir(parents=True, exist_ok=True)
    patient_robot(tree)

    def command(service: str, words: list[str]) -> list[str]:
        return in_tree(tree, words)

    changes = Changes(environment={"": {"FAIRLEAD_ROOT": str(tree)}}, command=command)
    with routed_stage(folder, changes) as robot:
        stage = AsyncStage(robot.robot)
        stage.proxies, stage.operators_file = robot.proxies, robot.operators_file
        stage.listen(folder)
        yield stage
