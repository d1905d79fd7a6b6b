"""Units for systemd, and what a service tells it."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
from pathlib import Path

import pytest
import yaml

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.registry import running_name
from fairlead.paths import deployment_path
from fairlead_tools.deploy.systemd_units import systemd_units
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.cli.command import fairlead_command, fairlead_environment
from tests.cli.command import fairlead_here as fairlead

pytestmark = pytest.mark.processes

READY_S = 60.0
WATCHDOG_US = 400_000
EXPOSURE = 25
"""In tenths, as `systemd-analyze security` says it; a unit without any setting has 96."""
ANALYZE = shutil.which("systemd-analyze")
FILE = "panda_mobile_two_hosts"


def units(folder: Path, *options: str) -> list[Path]:
    """Of the robot's host, as this user, whom systemd knows."""
    words = ["deploy", "units", FILE, "--host", "robot", "--out", str(folder), "--user", "root"]
    done = fairlead(*words, *options, state=folder)
    assert done.returncode == 0, done.stderr
    return sorted(folder.glob("*.service"))


@pytest.mark.skipif(ANALYZE is None, reason="no systemd-analyze here")
def test_systemd_takes_the_units_and_finds_them_hardened(tmp_path: Path) -> None:
    found = units(tmp_path / "units")
    names = [file.stem.removeprefix("fairlead-panda_mobile@") for file in found]
    assert names == ["hal", "router", "safety", "state_assembler"]
    assert ANALYZE is not None
    verified = subprocess.run(
        [ANALYZE, "verify", *map(str, sorted((tmp_path / "units").iterdir()))],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (verified.returncode, verified.stderr) == (0, "")
    for file in found:
        words = [ANALYZE, "security", "--offline=true", f"--threshold={EXPOSURE}", str(file)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout


@pytest.mark.skipif(ANALYZE is None, reason="no systemd-analyze here")
def test_a_router_that_robots_share_has_a_unit_and_they_have_none_for_it(tmp_path: Path) -> None:
    files = []
    for number, name in enumerate(("left", "right")):
        content = yaml.safe_load(deployment_path(FILE).read_text(encoding="utf-8"))
        content |= {"id": name, "router": {"host": "robot", "port": 7400 + number}}
        files.append(tmp_path / f"{name}.yaml")
        files[-1].write_text(yaml.safe_dump(content), encoding="utf-8")
    words = ["deploy", "units", *map(str, files), "--user", "root", "--out", str(tmp_path / "all")]
    done = fairlead(*words, state=tmp_path)
    assert done.returncode == 0, done.stderr
    [unit] = (tmp_path / "all").iterdir()
    start = next(one for one in unit.read_text().splitlines() if one.startswith("ExecStart="))
    assert start.endswith(f'"router" "{files[0]}" "{files[1]}"')
    assert ANALYZE is not None
    verified = subprocess.run(
        [ANALYZE, "verify", str(unit)], capture_output=True, text=True, check=False
    )
    assert (verified.returncode, verified.stderr) == (0, "")
    assert not any("router" in file.name for file in units(tmp_path / "one", "--without", "router"))


@pytest.mark.parametrize("words", [["--host", "robot"], ["--without", "router"]])
def test_several_files_are_those_of_a_router_alone(tmp_path: Path, words: list[str]) -> None:
    done = fairlead(
        "deploy", "units", FILE, FILE, "--out", str(tmp_path / "u"), *words, state=tmp_path
    )
    assert done.returncode == 1 and not (tmp_path / "u").exists()
    assert "--host, --without: expected one file with them, got several" in done.stderr


def test_robots_that_cannot_share_a_router_get_no_unit(tmp_path: Path) -> None:
    done = fairlead("deploy", "units", FILE, FILE, "--out", str(tmp_path / "u"), state=tmp_path)
    assert done.returncode == 1 and not (tmp_path / "u").exists()
    assert "have the same id; each robot needs its own" in done.stderr


def test_no_unit_needs_another_one(tmp_path: Path) -> None:
    for file in units(tmp_path / "units"):
        text = file.read_text(encoding="utf-8")
        assert not {"Requires", "BindsTo", "Requisite", "PartOf"} & {
            line.partition("=")[0] for line in text.splitlines() if ".service" in line
        }, text


def test_a_host_that_the_file_does_not_have_is_refused(tmp_path: Path) -> None:
    words = ["deploy", "units", FILE, "--out", str(tmp_path / "units")]
    for more in ([], ["--host", "laptop"]):
        done = fairlead(*words, *more, state=tmp_path)
        assert done.returncode == 1 and not (tmp_path / "units").exists()
        assert "--host: expected a host of the file, got " in done.stderr
        assert "(valid: robot, gpu)" in done.stderr


def test_a_user_that_would_write_a_line_of_its_own_is_refused(tmp_path: Path) -> None:
    words = ["deploy", "units", FILE, "--host", "robot", "--out", str(tmp_path / "units")]
    done = fairlead(*words, "--user", "x\nUser=root", state=tmp_path)
    assert done.returncode == 1 and not (tmp_path / "units").exists()
    assert "--user: expected a user's name of a-z 0-9 _ -, got" in done.stderr


@pytest.mark.parametrize(("user", "is_missing"), [("nobody-here", True), ("root", False)])
def test_a_user_that_this_machine_has_not_is_to_be_made(
    tmp_path: Path, user: str, is_missing: bool
) -> None:
    words = ["deploy", "units", FILE, "--host", "robot", "--out", str(tmp_path / "units")]
    done = fairlead(*words, "--user", user, state=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (f"\nmake the user: useradd --system {user}\n" in done.stdout) == is_missing
    home = "/var/lib/fairlead-panda_mobile"
    assert done.stdout.endswith(f"\ncommands there: sudo -u {user} HOME={home} fairlead status\n")
    unit = (tmp_path / "units" / "fairlead-panda_mobile@hal.service").read_text(encoding="utf-8")
    assert "\nEnvironment=HOME=%S/fairlead-panda_mobile\n" in unit  # %S: /var/lib


@pytest.mark.parametrize("service", ["safety", "state_assembler"])
@pytest.mark.parametrize("name", ["file", "@name"])
def test_a_service_says_when_it_is_ready_and_that_it_goes_on(
    tmp_path: Path, service: str, name: str
) -> None:
    """The gate from its timer's thread, the others from their event loop."""
    scratch = make_scratch(deployment_path("panda_mujoco"), tmp_path / "state", ScratchOptions())
    address = str(tmp_path / "notify") if name == "file" else f"@fairlead-{os.getpid()}-{service}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(address.replace("@", "\0"))
        manager.settimeout(READY_S)
        environment = fairlead_environment(tmp_path)
        environment |= {"NOTIFY_SOCKET": address, "WATCHDOG_USEC": str(WATCHDOG_US)}
        words = ["service", str(scratch.file), service, "--state-dir", str(tmp_path / "s")]
        with subprocess.Popen(
            fairlead_command(*words), env=environment, stdout=subprocess.DEVNULL
        ) as process:
            try:
                told = [manager.recv(100) for _ in range(8)]
            finally:
                process.terminate()
    assert process.returncode == 0
    assert set(told) == {b"READY=1", b"WATCHDOG=1"} and told.count(b"READY=1") == 1


def test_no_two_robots_have_a_unit_or_a_home_of_one_name(tmp_path: Path) -> None:
    base = load_deployment(deployment_path("panda_mobile_sim"))

    def named(robot: str, service: str, namespace: str = "fl") -> Deployment:
        services = dict(base.services)
        services[service] = services.pop("hal")
        return base.model_copy(update={"id": robot, "namespace": namespace, "services": services})

    several = [
        named("arm", "left-hal"), named("arm-left", "hal"), named("arm", "hal", "lab"),
        named("lab-arm", "hal"),
    ]  # fmt: skip
    texts = [systemd_units(tmp_path / "file", one, None, "fairlead") for one in several]
    names = [name for units in texts for name in units]
    assert len(set(names)) == len(names)
    homes = [
        {line for text in units.values() for line in text.splitlines() if "StateDirectory=" in line}
        for units in texts
    ]
    assert [len(one) for one in homes] == [1] * 4
    assert len(set.union(*homes)) == 4


@pytest.mark.parametrize("name", ["access", "router", "running"])
def test_a_robot_is_not_called_as_a_folder_of_all(name: str) -> None:
    content = yaml.safe_load(deployment_path("panda_mobile_sim").read_text(encoding="utf-8"))
    with pytest.raises(ValueError, match=f"expected another id: {name} is a folder"):
        Deployment.model_validate(content | {"id": name})


def test_of_a_deployment_on_hosts_each_is_listed_under_a_name_that_no_robot_has() -> None:
    deployment = load_deployment(deployment_path(FILE))
    other = deployment.model_copy(update={"id": f"{deployment.id}.gpu"})
    assert running_name(deployment, "gpu") != running_name(other)
