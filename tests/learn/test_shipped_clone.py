"""The clones that ship: their files are those that were trained, and nothing held out taught."""

from __future__ import annotations

import hashlib
import json

import pytest

from fairlead.paths import rskill_dir
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import load_skill
from fairlead_tools.parity.local_episode import make_policy

CLONES = ("bc-counter-to-cabinet", "bc-reach-cube")
HELD_OUT = set(range(200, 250))
MOST_BYTES = 4_000_000


@pytest.mark.parametrize("name", CLONES)
def test_its_files_are_those_of_its_recipe_and_load(name: str) -> None:
    clone, folder = load_skill(name), rskill_dir(name)
    told = json.loads((folder / "training.json").read_text(encoding="utf-8"))
    for file, digest in told["sha256"].items():
        assert hashlib.sha256((folder / file).read_bytes()).hexdigest() == digest
    options = clone.policy.options
    stated = [options["model"], options["statistics"]]
    assert {one["file"]: one["sha256"] for one in stated if isinstance(one, dict)} == told["sha256"]
    make_policy("test", clone)  # reads and compares them, and runs the network once
    assert sum(path.stat().st_size for path in folder.iterdir()) < MOST_BYTES
    assert admission_problems(clone, load_robot(clone.embodiments[0])) == []


@pytest.mark.parametrize("name", CLONES)
def test_no_seed_that_measures_it_taught_it(name: str) -> None:
    told = json.loads((rskill_dir(name) / "training.json").read_text(encoding="utf-8"))
    seeds = {seed for one in told["datasets"] for seed in one["seeds"]}
    assert seeds and not seeds & HELD_OUT
