"""Four services by their own commands, as docs/hosts.md says."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.equipment.live_robot import wait_for
from fairlead.deploy.registry import Registry
from tests.system.person import ROOT, Person, person_at

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

COMPOSE = "compose/panda_mujoco.yaml"
HAL_OF_ONES_OWN = (
    f".venv/bin/fairlead up {COMPOSE} --without hal",
    f".venv/bin/python docs/examples/minimal_hal.py --deployment {COMPOSE} --service hal "
    "--state-dir out/hal",
)
STARTS = [
    f".venv/bin/fairlead service {COMPOSE} {name}"
    for name in ("hal", "safety", "state_assembler", "runner")
]
PS, STATUS, RUN, DOWN = (
    f".venv/bin/fairlead {words}"
    for words in ("ps", "status", "run panda-joint-reach --seed 0", "down")
)


@pytest.fixture
def person(tmp_path: Path) -> Iterator[Person]:
    with person_at(tmp_path, COMPOSE, "hand") as person:
        yield person


def test_four_services_by_hand_run_a_goal_and_one_is_started_again(person: Person) -> None:
    for line in STARTS:
        person.start(line)
    registry = Registry(person.folder / "state")
    wait_for(lambda: sum(len(e.by_hand) for e in registry.entries()) == 4, "all are listed", 120.0)
    ran = person.shell(RUN)  # waits for those that still start
    assert ran.stdout.startswith("panda-joint-reach succeeded after "), ran.stderr
    assert person.states() == dict.fromkeys(
        ("hal", "runner", "safety", "state_assembler"), "ready, by hand"
    )
    assert person.shell(PS).returncode == person.shell(STATUS).returncode == 0

    twice = person.shell(STARTS[3])
    assert twice.returncode == 1 and "runner of hand" in twice.stderr
    assert "runs already (pid" in twice.stderr
    silent = person.fairlead("logs", "runner")
    assert silent.returncode == 1 and "started by hand" in silent.stderr
    refused = person.fairlead("restart", "runner")
    assert refused.returncode == 1 and "fairlead service " in refused.stderr

    assert person.terminals["runner"].ctrl_c() == 0
    gone = person.shell(STATUS)
    assert gone.returncode == 1 and "missing runner" in gone.stdout
    person.start(STARTS[3]).wait_ready()
    assert person.terminals["safety"].ctrl_c() == 0
    person.start(STARTS[1]).wait_ready()
    again = person.shell(RUN)
    assert again.stdout.startswith("panda-joint-reach succeeded after "), again.stderr

    assert person.shell(DOWN).returncode == 0
    wait_for(
        lambda: all(t.process.poll() is not None for t in person.terminals.values()), "all ended"
    )
    assert person.fairlead("ps").stdout.startswith("no deployment runs on this machine")


@pytest.mark.thorough
def test_up_leaves_out_what_is_run_by_hand_and_restarts_the_others_on_demand(
    person: Person,
) -> None:
    up, hal = HAL_OF_ONES_OWN
    (person.folder / "docs").symlink_to(ROOT / "docs")
    started = person.start(up, "up")
    started.wait_for(lambda line: "not seen yet: hal" in line, "the HAL is missed")
    person.start(hal, "hal")
    started.wait_for(lambda line: " is up;" in line, "the robot is up")
    (entry,) = json.loads(person.fairlead("ps", "--json").stdout)
    assert entry["elsewhere"] == ["hal"]
    assert {one["state"] for one in entry["services"].values()} == {"ready"}

    restarted = person.fairlead("restart", "runner")
    assert restarted.returncode == 0, restarted.stderr
    assert re.fullmatch(r"restarted runner of hand\d+ \(pid \d+\)\n", restarted.stdout)
    assert person.fairlead("arm").returncode == 0
    gate = person.fairlead("restart", "safety")
    assert gate.returncode == 0, gate.stderr
    status = json.loads(person.fairlead("status", "--json").stdout)
    assert status["gate"]["state"] in ("boot", "disarmed"), "it ended cleanly: nothing to reset"
    unknown = person.fairlead("restart", "camera")
    assert unknown.returncode == 1 and "a service that runs here" in unknown.stderr

    assert person.fairlead("down").returncode == 0
    assert started.process.wait(timeout=30.0) == 0
    assert person.terminals["hal"].ctrl_c() == 0


def test_a_runner_without_a_skill_for_its_robot_waits_and_says_how_to_make_one(
    person: Person, tmp_path: Path
) -> None:
    tree = tmp_path / "tree"
    (tree / "rskills").mkdir(parents=True)
    (tree / "robots").symlink_to(ROOT / "robots")
    person.root = tree
    runner = person.start(STARTS[3])
    runner.wait_ready()
    assert any(
        "no skill is made for panda; make one: fairlead skill new" in x for x in runner.lines
    )
    assert runner.ctrl_c() == 0
