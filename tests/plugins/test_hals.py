"""A HAL from another package, from a script, or from somebody else; and a robot without skills."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import pytest
import yaml

from bench.equipment.live_robot import wait_for
from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ConfigError
from fairlead_tools.supervisor.command_line import service_command
from tests.cli.command import fairlead, fairlead_command, fairlead_environment
from tests.cli.command import fairlead_here as command
from tests.plugins.package import install, run
from tests.repo.tree import ROOT

MINIMAL = ROOT / "docs" / "examples" / "minimal_hal.py"
NUMBERS = count()
OURS = "valid: hal_kinematic, hal_mujoco, hal_ros2, hal_sim, hal_so101 from fairlead 0.1.0"


def deployment(folder: Path, hal: dict[str, Any], *others: str) -> Path:
    """A deployment file of the Panda with a HAL, the gate, and other services by their kind."""
    specs = {"hal": hal, "safety": {"run": "safety"}, **{name: {"run": name} for name in others}}
    file = folder / "robot.yaml"
    identity = {"robot": "panda", "id": f"plug{next(NUMBERS)}", "pacing": "lockstep"}
    file.write_text(yaml.safe_dump(identity | {"services": specs}, sort_keys=False))
    return file


def words(file: Path, service: str = "hal") -> list[str]:
    return service_command(file, load_deployment(file), service, Path("/state"))


@pytest.mark.processes
def test_a_hal_that_no_package_has_is_refused_with_those_there_are(tmp_path: Path) -> None:
    file = deployment(tmp_path, {"run": "hal_simm"})
    with pytest.raises(ConfigError) as caught:
        words(file)
    said = f"service hal: run: expected a HAL, got 'hal_simm' ({OURS})"
    assert str(caught.value) == f"{file}:6:5: {said}"
    refused = command("up", str(file), state=tmp_path)
    assert (refused.returncode, refused.stderr) == (1, f"ERROR {caught.value}\n")


@pytest.mark.processes
def test_a_misspelt_service_is_a_second_hal_and_refused_as_such(tmp_path: Path) -> None:
    file = deployment(tmp_path, {"run": "hal_sim"}, "skill_runer")
    refused = command("up", str(file), state=tmp_path)
    assert refused.returncode == 1
    assert (
        "expected exactly one HAL, got hal (hal_sim), skill_runer (skill_runer); run names one of "
        f"safety, state_assembler, skill_runner, or a HAL ({OURS}; or external)"
    ) in refused.stderr


@pytest.mark.parametrize("hal", [{}, {"run": "hal_sim", "command": ["python", "x.py"]}])
def test_a_service_has_either_run_or_command(hal: dict[str, Any], tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="services.hal: expected run or command, got"):
        load_deployment(deployment(tmp_path, hal))


def test_a_command_is_found_from_the_files_folder_and_told_who_it_is(tmp_path: Path) -> None:
    file = deployment(tmp_path, {"command": ["python", "./my_hal.py", "--fast"]})
    assert words(file) == [
        *(sys.executable, str(tmp_path / "my_hal.py"), "--fast"),
        *("--deployment", str(file), "--service", "hal", "--state-dir", "/state"),
    ]


@pytest.mark.processes
def test_what_somebody_else_starts_is_started_by_nobody_here(tmp_path: Path) -> None:
    file = deployment(tmp_path, {"run": "external"})
    assert load_deployment(file).processes(None) == ["safety"]
    refused = command("service", str(file), "hal", state=tmp_path)
    what = "service hal: run is external: somebody else starts it"
    assert refused.stderr == f"ERROR {file}:6:5: {what}\n"


@pytest.mark.processes
@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("import torrch\n",
         "acme:DRIVER cannot be imported: ModuleNotFoundError: No module named 'torrch'; mend or "
         "uninstall that package"),
        ("DRIVER = print\n",
         "acme:DRIVER: expected a fairlead.hal.process.HalDriver, got <built-in function print>"),
    ],
)  # fmt: skip
def test_a_broken_hal_is_named_with_its_package(text: str, complaint: str, tmp_path: Path) -> None:
    site = tmp_path / "site"
    install(site, "acme-hal", {"fairlead.hals": {"acme": "acme:DRIVER"}}, {"acme.py": text})
    file = deployment(tmp_path, {"run": "acme"})
    arguments = ("--deployment", str(file), "--service", "hal", "--state-dir", str(tmp_path))
    done = run(site, "-m", "fairlead.hal.serve", *arguments)
    said = f"ERROR fairlead-hal: HAL 'acme' of acme-hal 1.2: {complaint}\n"
    assert (done.returncode, done.stdout.partition(" ")[2], done.stderr) == (1, said, "")


class Up:
    """``fairlead up`` of a file, and what it prints."""

    def __init__(self, file: Path, state: Path) -> None:
        self.lines: list[str] = []
        self.process = subprocess.Popen(
            fairlead_command("up", str(file)),
            env=fairlead_environment(state),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as stream:
            self.lines.extend(stream)

    def wait_says(self, text: str) -> None:
        wait_for(
            lambda: self.process.poll() is not None or any(text in line for line in self.lines),
            text,
            120.0,
        )
        assert any(text in line for line in self.lines), "".join(self.lines)


@pytest.fixture
def ends() -> Iterator[list[subprocess.Popen[str]]]:
    started: list[subprocess.Popen[str]] = []
    yield started
    for process in reversed(started):
        process.terminate()
        process.wait(timeout=30.0)


@pytest.mark.processes
def test_a_robot_whose_hal_somebody_else_starts_is_up_without_skills(
    tmp_path: Path, ends: list[subprocess.Popen[str]]
) -> None:
    file = deployment(tmp_path, {"run": "external"})
    up = Up(file, tmp_path / "state")
    ends.append(up.process)
    up.wait_says("not seen yet: hal; start with: whatever hal is (run: external)")
    script = [sys.executable, str(MINIMAL), "--deployment", str(file), "--service", "hal"]
    ends.append(
        subprocess.Popen(
            [*script, "--state-dir", str(tmp_path / "hal")], stdout=subprocess.DEVNULL, text=True
        )
    )
    up.wait_says("in another terminal: fairlead status; fairlead arm for a program of your own")
    armed = command("arm", state=tmp_path / "state")
    assert armed.returncode == 0, armed.stderr
    refused = command("run", "panda-joint-reach", state=tmp_path / "state")
    assert refused.returncode == 1
    assert "has no skill_runner, so it runs no skills" in refused.stderr
    assert command("down", state=tmp_path / "state").returncode == 0


@pytest.mark.processes
def test_a_hal_of_real_robots_waits_for_nobody_and_warns_of_a_simulators_limits(
    tmp_path: Path,
) -> None:
    file = deployment(tmp_path, {"run": "hal_so101", "options": {"port": "/dev/none"}})
    refused = fairlead("service", str(file), "hal", state=tmp_path)
    assert "service hal: hal_so101: pacing: expected realtime, got lockstep" in refused.stdout
    file.write_text(file.read_text().replace("lockstep", "realtime"))
    warned = fairlead("service", str(file), "hal", state=tmp_path)
    said = "profile sim has the limits of a simulator, and hal_so101 may move a real robot"
    assert said in warned.stdout
    assert warned.returncode == 1
