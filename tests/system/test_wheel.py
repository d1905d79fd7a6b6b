"""The wheel, installed where nothing of the checkout is: it has all that it needs.

What is installed beside it is tried here too: to make such an environment takes long.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import stat
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from fairlead.paths import gate_binary
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.repo.tree import ROOT, files
from tests.system.wheel_environment import UV, Person

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]

GATE = "build/safety/fairlead-safety"
EXAMPLE = ROOT / "docs" / "examples" / "acme_arm"
SKILL = "acme_arm/rskills/acme-reach/rskill.yaml"


def contents(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        return {name: archive.read(name) for name in names if "dist-info" not in name}


def test_the_gate_in_the_wheel_runs_alone_and_claims_no_more_machines_than_are_true(
    person: Person, wheel: Path
) -> None:
    gate = person.tree / GATE
    assert gate.stat().st_mode & stat.S_IXUSR
    assert subprocess.run([gate, "--help"], capture_output=True, timeout=10).returncode == 0
    reader = gate.with_name("fairlead-decisions")
    assert subprocess.run([reader, "--help"], capture_output=True, timeout=10).returncode == 0
    binaries = [gate, reader, *gate.parent.glob("*.so")]
    asked = ""
    for one in binaries:
        shown = ["readelf", "--wide", "--dynamic", "--version-info", str(one)]
        asked += subprocess.run(shown, check=True, capture_output=True, text=True).stdout
        loaded = subprocess.run(["ldd", one], check=True, capture_output=True, text=True).stdout
        own = {path for path in re.findall(r"=> (\S+)", loaded) if "/lib/" not in path[:10]}
        assert own <= {str(binary) for binary in binaries} and "not found" not in loaded
    assert set(re.findall(r"R(?:UN)?PATH.*\[(.*)\]", asked)) <= {"$ORIGIN"}
    symbols = [int(minor) for minor in re.findall(r"\bGLIBC_2\.(\d+)", asked)]
    tag = re.search(r"-(manylinux_2_(\d+)|linux)_\w+\.whl$", wheel.name)
    assert tag and (tag[1] == "linux" or int(tag[2]) >= max(symbols))


def test_the_licences_of_what_is_compiled_in_come_with_it(person: Person) -> None:
    text = (person.tree / "third-party-licences.txt").read_text(encoding="utf-8")
    lock = tomllib.loads((ROOT / "services/safety/zenoh_shim/Cargo.lock").read_text())
    [zenoh] = [one["version"] for one in lock["package"] if one["name"] == "zenoh"]
    assert f"\nzenoh {zenoh} (EPL-2.0 OR Apache-2.0)\n" in text
    assert "\nEigen\n" in text and "Mozilla Public License" in text
    assert "no licence named" not in text


def test_nothing_installed_points_back_into_the_checkout(person: Person) -> None:
    places = [*person.site.glob("fairlead*"), *person.site.glob("*.pth"), *person.bin.iterdir()]
    candidates = [one for place in places for one in (place, *place.rglob("*"))]
    assert len(candidates) > 100
    pointing = [
        str(path)
        for path in candidates
        if path.is_file() and not path.is_symlink() and os.fsencode(ROOT) in path.read_bytes()
    ]
    assert pointing == []


def test_it_says_what_it_is_and_what_it_has(person: Person) -> None:
    assert "Usage: fairlead" in person.does("fairlead", "--help")
    said = person.does("fairlead", "--version")
    assert f"  tree: {person.tree}\n" in said and f"  gate: {person.tree / GATE}, SHA-256" in said
    assert re.search(
        r"^oracle-counter-to-cabinet +admitted$", person.does("fairlead", "skill", "ls"), re.M
    )
    assert person.does("fairlead", "robot", "show", "panda").startswith("panda, profile sim")
    refused = person.run("fairlead", "up", "nowhere")
    assert refused.returncode == 2 and "panda_mobile_sim" in refused.stderr


def test_own_skills_go_to_the_users_folder_and_leave_the_installation_alone(person: Person) -> None:
    before = sorted(person.tree.rglob("*"))
    person.does("fairlead", "skill", "new", "my-wave")
    person.does("fairlead", "skill", "install", "my-wave")
    installed = person.home / ".local/share/fairlead/rskills/my-wave"
    assert sorted(path.name for path in installed.iterdir()) == ["policy.py", "rskill.yaml"]
    assert re.search(r"^my-wave +admitted$", person.does("fairlead", "skill", "ls"), re.M)
    assert sorted(person.tree.rglob("*")) == before


@pytest.mark.thorough
def test_the_demo_does_its_task(person: Person) -> None:
    person.does("fairlead", "demo", "--no-video")
    summary = json.loads((person.home / "out/demo/summary.json").read_text(encoding="utf-8"))
    assert (summary["outcome"], summary["decided_by"]) == ("succeeded", "task")


@pytest.fixture
def own_ports(person: Person, tmp_path: Path) -> None:
    """The packaged deployment of the Panda on ports that nobody else uses."""
    file = person.tree / "compose" / "panda_mujoco.yaml"
    text = make_scratch(file, tmp_path / "scratch", ScratchOptions()).file.read_text("utf-8")
    file.unlink()
    file.write_text(text, encoding="utf-8")


@pytest.fixture
def up(person: Person, own_ports: None) -> Iterator[subprocess.Popen[str]]:
    with person.up("panda_mujoco") as (process, _):
        yield process


def test_a_packaged_deployment_runs_by_its_name(person: Person, up: subprocess.Popen[str]) -> None:
    assert "succeeded" in person.does("fairlead", "run", "panda-joint-reach")
    assert "stopped panda" in person.does("fairlead", "down")
    assert up.wait(timeout=30.0) == 0


def test_without_robosuite_the_one_command_that_installs_it_is_named(person: Person) -> None:
    code = "import sys; sys.modules['robosuite'] = None; import fairlead_hal_sim.quiet_robosuite"
    refused = person.run("python", "-c", code)
    assert refused.stderr.strip().splitlines()[-1] == (
        "fairlead.errors.ConfigError: hal_sim: the Python package robosuite is not installed; "
        f"install the locked set, which has it: {person.bin}/python -m pip install --no-deps -r "
        f"{person.tree}/requirements-run.lock"
    )


def test_the_source_archive_has_every_file_and_makes_the_same_wheel(
    dist: Path, wheel: Path, tmp_path: Path
) -> None:
    [archive] = dist.glob("*.tar.gz")
    subprocess.run(["tar", "-xzf", archive, "-C", tmp_path], check=True)
    [source] = tmp_path.iterdir()
    missing = [str(p) for p in files() if p.parts[0] != ".ci" and not (source / p).is_file()]
    assert missing == []
    again = tmp_path / "dist"
    command = [sys.executable, "-m", "hatchling", "build", "-d", str(again), "-t", "wheel"]
    environment = os.environ | {"FAIRLEAD_GATE_DIR": str(gate_binary().parent)}
    subprocess.run(command, cwd=source, env=environment, check=True, timeout=120)
    assert contents(again / wheel.name) == contents(wheel)


def test_a_wheel_without_a_gate_is_not_built(tmp_path: Path) -> None:
    done = subprocess.run(
        [ROOT / "scripts/build-wheel", "--gate", tmp_path, "--out", tmp_path / "dist"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 1
    assert (
        f"wheel: no fairlead-safety in {tmp_path}; build it with: scripts/build-gate" in done.stderr
    )
    assert not list((tmp_path / "dist").glob("*.whl"))


# --- a whole robot from a package of one's own, installed beside it: docs/examples/acme_arm -------


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
def customers_up(customer: Person) -> Iterator[list[str]]:
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
    customer: Person, customers_up: list[str]
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
        "skill my-reach or the robot has changed: its policy is loaded anew" in line
        for line in customers_up
    )
    assert "stopped acme" in customer.does("fairlead", "down")
