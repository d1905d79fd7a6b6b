"""Container files: linted, translated into podman's commands, and those run without a container."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.paths import deployment_path, repo_root
from fairlead_tools.deploy.containers import FILE, HOME
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.cli.command import TIMEOUT_S, fairlead_command
from tests.cli.command import fairlead_here as fairlead
from tests.supervisor.two_hosts_file import content as two_hosts

pytestmark = pytest.mark.processes

TWO_HOSTS = "panda_mobile_two_hosts"
STARTS_MOST = 20
"""Times 3 s, in which `run` looks for the services."""
TOOLS = Path(sys.executable).parent
PODMAN = """\
#!/bin/sh
# As much of podman as podman-compose asks of it; what it is told to do goes to a file.
echo "$@" >> "$0.told"
case "$1" in
--version) echo podman version 5.0.0 ;;
*) echo '[]' ;;
esac
"""


def written(folder: Path, *words: str) -> dict[str, Any]:
    """The compose file for the words after ``deploy containers``."""
    done = fairlead("deploy", "containers", *words, "--out", str(folder), state=folder)
    assert done.returncode == 0, done.stderr
    content = yaml.safe_load((folder / "compose.yaml").read_text(encoding="utf-8"))
    assert isinstance(content, dict)
    return content


def test_the_containerfile_has_no_fault_that_hadolint_knows() -> None:
    words = [str(TOOLS / "hadolint"), str(repo_root() / "compose/Containerfile")]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "")


def test_podman_would_start_each_process_of_the_host_with_few_rights(tmp_path: Path) -> None:
    written(tmp_path, TWO_HOSTS, "--host", "robot")
    podman = tmp_path / "podman"
    podman.write_text(PODMAN, encoding="utf-8")
    podman.chmod(0o755)
    done = subprocess.run(
        [TOOLS / "podman-compose", "--podman-path", podman, "up", "--detach"],
        cwd=tmp_path, env=os.environ | {"USER_ID": "1000", "USERNS": "keep-id"},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    told = (tmp_path / "podman.told").read_text(encoding="utf-8").splitlines()
    started = [line for line in told if line.partition(" ")[0] in ("run", "create")]
    assert len(started) == 4, told
    for line in started:
        for word in (
            "--read-only", "--cap-drop ALL", "--network=host", "no-new-privileges",
            "--userns keep-id",
        ):  # fmt: skip
            assert word in line, line
        assert "--pod" not in line


NAMES = {  # robot and namespace; ":" and "." may be in no project's name
    "two namespaces": (("arm", "fl"), ("arm", "lab")),
    "a hyphen that is no border": (("lab-arm", "fl"), ("arm", "lab")),
    "a dot": (("arm.1", "fl"), ("arm-1", "fl")),
}


@pytest.mark.parametrize("case", NAMES)
def test_no_two_robots_have_a_project_of_one_name(case: str, tmp_path: Path) -> None:
    projects = []
    for number, (robot, namespace) in enumerate(NAMES[case]):
        spec = yaml.safe_load(deployment_path("panda_mujoco").read_text(encoding="utf-8"))
        file = tmp_path / f"{number}.yaml"
        file.write_text(yaml.safe_dump(spec | {"id": robot, "namespace": namespace}))
        projects.append(written(tmp_path / str(number), str(file))["name"])
    assert projects[0] != projects[1]
    assert all(re.fullmatch(r"[a-z0-9][a-z0-9_-]*", name) for name in projects), projects


def test_a_router_that_robots_share_has_a_compose_file_of_its_own(tmp_path: Path) -> None:
    files = [tmp_path / "left.yaml", tmp_path / "right.yaml"]
    for number, file in enumerate(files):
        router = {"host": "robot", "port": 7400 + number}
        file.write_text(yaml.safe_dump(two_hosts(id=file.stem, router=router)))
    content = written(tmp_path, *map(str, files))
    assert content["name"] == "fairlead-router"
    [router] = content["services"].values()
    inside = ["/etc/fairlead/robot1.yaml", "/etc/fairlead/robot2.yaml"]
    assert router["command"] == ["router", *inside]
    mounts = [f"{file}:{path}:ro" for file, path in zip(files, inside, strict=True)]
    assert router["volumes"] == [*mounts, f"./state:{HOME}"]
    words = ["deploy", "containers", *map(str, [*files, files[0]]), "--out", str(tmp_path / "no")]
    done = fairlead(*words, state=tmp_path)
    assert done.returncode == 1 and not (tmp_path / "no").exists()
    assert "router: left and left have the same id; each robot needs its own" in done.stderr


def test_a_host_has_to_be_named_and_a_user(tmp_path: Path) -> None:
    out = str(tmp_path / "out")
    done = fairlead("deploy", "containers", TWO_HOSTS, "--out", out, state=tmp_path)
    assert done.returncode == 1 and "--host: expected a host of the file" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.thorough
def test_what_the_containers_run_is_a_robot_that_moves(tmp_path: Path) -> None:
    scratch = make_scratch(deployment_path("panda_mujoco"), tmp_path / "state", ScratchOptions())
    content = written(tmp_path, str(scratch.file))
    home = tmp_path / "home"
    home.mkdir()
    environment = {
        key: value for key, value in os.environ.items() if not key.startswith("FAIRLEAD")
    } | {"HOME": str(home)}
    with started(content, scratch.file, environment):
        words = ["run", "panda-joint-reach", "--seed", "0", "--deployment", str(scratch.file)]
        for _ in range(STARTS_MOST):
            done = subprocess.run(
                fairlead_command(*words), env=environment, capture_output=True, text=True,
                timeout=TIMEOUT_S, check=False,
            )  # fmt: skip
            if "not seen within" not in done.stderr:
                break
        assert done.returncode == 0, done.stdout + done.stderr
        assert "succeeded" in done.stdout


@contextmanager
def started(content: dict[str, Any], file: Path, environment: dict[str, str]) -> Iterator[None]:
    """Its services, each as a process of its own that finds in its home what a container would."""
    processes = []
    try:
        for service in content["services"].values():
            assert service["environment"] == {"HOME": HOME}
            words = [str(file) if word == FILE else word for word in service["command"]]
            processes.append(
                subprocess.Popen(
                    fairlead_command(*words), env=environment, stdout=subprocess.DEVNULL
                )
            )
        yield
    finally:
        for process in processes:
            process.terminate()
        ended = [process.wait(30) for process in processes]
    assert ended == [0] * len(processes)
