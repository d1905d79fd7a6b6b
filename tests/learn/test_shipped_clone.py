"""The clone that ships: its files are those that were trained, and nothing held out taught it."""

from __future__ import annotations

import hashlib
import json

from fairlead.paths import rskill_dir
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import load_skill
from fairlead_tools.parity.local_episode import make_policy

CLONE = load_skill("bc-counter-to-cabinet")
FOLDER = rskill_dir(CLONE.id)
HELD_OUT = set(range(200, 250))
MOST_BYTES = 4_000_000


def test_its_files_are_those_of_its_recipe_and_load() -> None:
    told = json.loads((FOLDER / "training.json").read_text(encoding="utf-8"))
    for name, digest in told["sha256"].items():
        assert hashlib.sha256((FOLDER / name).read_bytes()).hexdigest() == digest
    options = CLONE.policy.options
    stated = [options["model"], options["statistics"]]
    assert {one["file"]: one["sha256"] for one in stated if isinstance(one, dict)} == told["sha256"]
    make_policy(CLONE)  # reads and compares them, and runs the network once
    assert sum(path.stat().st_size for path in FOLDER.iterdir()) < MOST_BYTES
    assert admission_problems(CLONE, load_robot("panda_mobile")) == []


def test_no_seed_that_measures_it_taught_it() -> None:
    told = json.loads((FOLDER / "training.json").read_text(encoding="utf-8"))
    seeds = {seed for one in told["datasets"] for seed in one["seeds"]}
    assert seeds and not seeds & HELD_OUT
