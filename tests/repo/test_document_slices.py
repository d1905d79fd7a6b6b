"""Code in the documents is a slice of a file that runs."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest
import yaml

from fairlead.layout import load_layout
from fairlead.operate.chain import read_chain
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import SkillManifest, read_skill
from fairlead.skill.state_contract import StateContract
from tests.repo.tree import ROOT

BINDINGS = (ROOT / "docs" / "examples" / "libero_eef8d_bindings.yaml").read_text()


@pytest.mark.processes
def test_notebook_example_prints_the_state_vector() -> None:
    done = subprocess.run(
        [sys.executable, "docs/examples/layout_in_a_notebook.py"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    tcp_in_base = [0.5, 0.0, 1.1, 1.0, 0.0, 0.0, 0.0]
    base_in_odom = [2.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.8]
    fingers = [0.03, -0.03]
    assert json.loads(done.stdout) == [*tcp_in_base, *base_in_odom, *fingers]


def test_bindings_for_libero_are_the_layouts_example() -> None:
    contract = StateContract.model_validate(yaml.safe_load(BINDINGS))
    assert contract.bindings == load_layout("libero_eef8d").example


def test_the_example_of_a_manifest_has_every_key_and_is_admitted() -> None:
    folder = ROOT / "docs" / "examples" / "my-pick"
    skill = read_skill(folder)
    shown = yaml.safe_load((folder / "rskill.yaml").read_text())
    assert set(shown) == set(SkillManifest.model_fields)
    assert admission_problems(skill, load_robot("panda_mobile")) == []


def test_the_example_of_a_chain_is_one() -> None:
    chain = read_chain(ROOT / "docs" / "examples" / "pick-and-place.yaml")
    assert [goal.name for goal in chain.goals] == ["pick", "drive", "place"]
