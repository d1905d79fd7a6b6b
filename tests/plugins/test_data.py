"""Robots, skills and deployment files of other packages, found without importing anything."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import load_robot
from tests.plugins.package import fairlead, install, run
from tests.repo.tree import ROOT


def with_data(site: Path, name: str = "acme-data", module: str = "acme_data") -> None:
    """A package with a copy of a robot, a skill for it, and a deployment."""
    robot = ROOT / "robots" / "panda"
    files = {
        f"{module}/__init__.py": "raise RuntimeError('imported')\n",
        f"{module}/rskills/acme-reach/rskill.yaml": (
            (ROOT / "rskills/panda-joint-reach/rskill.yaml")
            .read_text()
            .replace("id: panda-joint-reach", "id: acme-reach")
            .replace("embodiments: [panda]", "embodiments: [acme]")
        ),
        f"{module}/compose/acme.yaml": (ROOT / "compose/panda_mujoco.yaml")
        .read_text()
        .replace("robot: panda ", "robot: acme "),
    }
    for file in ("robot.yaml", "panda.urdf", "capsules.yaml"):
        text = (robot / file).read_text().replace("id: panda\n", "id: acme\n", 1)
        files[f"{module}/robots/acme/{file}"] = text
    install(site, name, {"fairlead.data": {name: module}}, files)


@pytest.mark.processes
def test_robots_skills_and_deployments_of_a_package_are_listed_and_found(tmp_path: Path) -> None:
    with_data(tmp_path)
    robots = json.loads(fairlead(tmp_path, "robot", "ls", "--json").stdout)
    assert "acme" in [row["robot"] for row in robots if "error" not in row]
    skills = fairlead(tmp_path, "skill", "ls", "--robot", "acme", "--json")
    admitted = [row["skill"] for row in json.loads(skills.stdout) if row["admitted"]]
    assert admitted == ["acme-reach"]
    code = "from fairlead.paths import deployment_path; print(deployment_path('acme'))"
    assert run(tmp_path, "-c", code).stdout.strip() == str(tmp_path / "acme_data/compose/acme.yaml")
    refused = fairlead(tmp_path, "up", "acmee")
    assert refused.returncode == 2 and "acme, dual_panda_mujoco, " in refused.stderr


@pytest.mark.processes
def test_a_package_whose_folder_is_gone_is_in_nobodys_way(tmp_path: Path) -> None:
    install(tmp_path, "acme-data", {"fairlead.data": {"acme": "acme_data.gone"}}, {})
    assert fairlead(tmp_path, "robot", "show", "panda").returncode == 0


@pytest.mark.processes
def test_a_package_that_is_half_removed_is_told_and_in_nobodys_way(tmp_path: Path) -> None:
    install(tmp_path, "acme-data", {"fairlead.data": {"acme": "acme_data"}}, {})
    info = tmp_path / "acme_data-1.2.dist-info"
    (info / "METADATA").unlink()
    done = fairlead(tmp_path, "--version")
    assert (done.returncode, done.stdout.count("acme")) == (0, 0), done.stderr
    [told] = done.stderr.splitlines()
    assert told.startswith(f"{info}: not read, install or remove that package anew: ")


@pytest.mark.processes
def test_a_robot_that_two_packages_bring_is_refused_with_both(tmp_path: Path) -> None:
    with_data(tmp_path)
    with_data(tmp_path, "other-data", "other_data")
    refused = fairlead(tmp_path, "robot", "show", "acme")
    assert refused.stderr == (
        f"ERROR robot 'acme': {tmp_path}/acme_data/robots/acme and "
        f"{tmp_path}/other_data/robots/acme have it; uninstall one of the packages\n"
    )


@pytest.mark.parametrize("place", ["acme_data", "acme_data/robots/acme"])
@pytest.mark.processes
def test_a_packages_folder_is_no_checkout(place: str, tmp_path: Path) -> None:
    with_data(tmp_path)
    code = f"import os; os.chdir({str(tmp_path / place)!r}); from fairlead.paths import repo_root"
    done = run(tmp_path, "-c", f"{code}; print(repo_root())")
    assert done.stdout.strip() == str(ROOT)


def test_the_examples_gate_file_is_what_its_robot_compiles_to(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    robots = ROOT / "docs/examples/acme_arm/acme_arm/robots"
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(robots))
    compiled = compile_gate_config(load_robot("acme_arm"), "sim")
    assert (robots / "acme_arm/gate.sim.json").read_text() == compiled
