"""docs/examples/acme_arm: a whole robot from a package of one's own, beside the wheel."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator

import pytest

from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.repo.tree import ROOT
from tests.system.wheel_environment import UV, Person

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

EXAMPLE = ROOT / "docs" / "examples" / "acme_arm"
SKILL = "acme_arm/rskills/acme-reach/rskill.yaml"


@pytest.fixture(scope="module")
def customer(person: Person, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Person]:
    """The person, with the example's wheel installed too; its deployment has ports of its own."""
    folder = tmp_path_factory.mktemp("acme")
    source = folder / "acme_arm"
    shutil.copytree(EXAMPLE, source, ignore=shutil.ignore_patterns("__pycache__"))
    compose = source / "acme_arm" / "compose" / "acme_arm.yaml"
    options = ScratchOptions()
    compose.write_text(make_scratch(compose, folder / "scratch", options).file.read_text())
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=source, check=True, timeout=60)
    [wheel] = folder.glob("*.whl")
    single = ["pip", "install", "--quiet", "--no-deps", "--offline", "--no-cache"]
    python = person.bin / "python"
    subprocess.run([UV, *single, "--python", python, wheel], check=True)
    yield person
    subprocess.run([UV, "pip", "uninstall", "--quiet", "--python", python, "acme-arm"], check=True)


@pytest.fixture
def up(customer: Person) -> Iterator[list[str]]:
    """What ``fairlead up acme_arm`` prints."""
    with customer.up("acme_arm") as (_, lines):
        yield lines


@pytest.mark.thorough
def test_its_robot_skill_layout_policy_and_hal_are_found_by_name(customer: Person) -> None:
    assert customer.does("fairlead", "--version").splitlines()[-1] == (
        "  acme-arm 1.0: HAL acme_arm, policy backend acme_reach, layout acme_tip_5d, "
        "folder of data acme_arm"
    )
    assert "acme_arm" in customer.does("fairlead", "robot", "ls")
    assert "acme-arm 1.0" in customer.does("fairlead", "layout", "ls")
    said = customer.does("fairlead", "skill", "check", "acme-reach")
    assert said == "acme-reach may run on acme_arm\n"
    wrong = customer.home / "wrong.yaml"
    text = (customer.site / "acme_arm/compose/acme_arm.yaml").read_text()
    wrong.write_text(text.replace("run: acme_arm", "run: acme_amr"))
    refused = customer.run("fairlead", "up", str(wrong))
    assert refused.stderr == (
        f"ERROR {wrong}:10:5: service hal: run: expected a HAL, got 'acme_amr' (valid: acme_arm "
        "from acme-arm 1.0; hal_kinematic, hal_mujoco, hal_ros2, hal_sim, hal_so101 from fairlead "
        "0.1.0)\n"
    )


def test_it_runs_its_skill_and_an_edited_folder_of_ones_own_without_installing_again(
    customer: Person, up: list[str]
) -> None:
    ran = customer.does("fairlead", "run", "acme-reach")
    assert ran.startswith("acme-reach succeeded after ")
    assert "(decided by the policy): the tip is at 0.335 0.183 0.488" in ran

    own = customer.home / "my-reach" / "rskill.yaml"
    own.parent.mkdir()
    text = (customer.site / SKILL).read_text().replace("id: acme-reach", "id: my-reach")
    own.write_text(text.replace("target_rad: [0.5, 0.3]", "target_rad: [0.0, 0.0]"))
    first = customer.run("fairlead", "run", "./my-reach")
    assert "the tip is at 0.400 0.000 0.370" in first.stdout, first.stderr
    assert f"my-reach -> {own.parent}\n" in first.stderr, "it says what it linked"
    own.write_text(text.replace("target_rad: [0.5, 0.3]", "target_rad: [0.2, 0.0]"))
    again = customer.run("fairlead", "run", "my-reach")
    assert "the tip is at 0.392 0.079 0.370" in again.stdout, again.stderr
    assert any(
        "skill my-reach or the robot has changed: its policy is loaded anew" in line for line in up
    )
    assert "stopped acme" in customer.does("fairlead", "down")
