"""Where services of one host meet nobody but this user gets in, whatever runs or was killed."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
import yaml

from bench.equipment.live_robot import wait_for
from bench.faults.live_stage import LiveStage, live_stage
from fairlead.deploy.credentials import access_dir
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.process_table import is_listening, listener_of
from fairlead.deploy.sockets import LONGEST_PATH, forget_sockets, socket_endpoint, socket_path
from fairlead.errors import ConfigError, TransportError
from fairlead.keys import Keys
from fairlead.paths import ACCESS_VARIABLE, repo_root
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from tests.access.intruder import NOBODY
from tests.cli.command import fairlead_command

AWAY = "state_assembler"
FILE = repo_root() / "compose" / "panda_mobile_sim.yaml"
ONE = Keys("one")
TRIES = """
import json, os, socket, sys
user, away, *others = sys.argv[1:]
os.setgroups([])
os.setresgid(int(user), int(user), int(user))
os.setresuid(int(user), int(user), int(user))
folder, new = os.path.dirname(away), away + ".new"

def dial(path):
    with socket.socket(socket.AF_UNIX) as one:
        one.connect(path)

def listen(path):
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(path)

tries = {
    "list": lambda: os.listdir(folder),
    "dial": lambda: dial(others[0]),
    "listen": lambda: listen(away),
    "link": lambda: os.symlink("/tmp", new),
    "remove": lambda: os.unlink(others[0]),
    "move": lambda: os.rename(folder, folder + ".old"),
}
found = {}
for name, one in tries.items():
    try:
        one()
        found[name] = "done"
    except OSError as error:
        found[name] = type(error).__name__
print(json.dumps(found))
"""


@pytest.fixture
def access(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(ACCESS_VARIABLE, str(tmp_path / "access"))
    return tmp_path / "access"


@pytest.fixture
def far(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder whose sockets' paths are too long, and have signs that end an endpoint."""
    folder = tmp_path / ("far?#;" * 30)
    monkeypatch.setenv(ACCESS_VARIABLE, str(folder))
    yield folder
    forget_sockets(ONE)


def path_of(keys: Keys, service: str) -> Path:
    return Path(socket_path(socket_endpoint(keys, service)))


@pytest.mark.processes
@pytest.mark.timeout(240)
@pytest.mark.skipif(os.getuid() != 0, reason="only root can become another user")
def test_another_user_can_do_nothing_there_also_while_a_service_is_away(tmp_path: Path) -> None:
    tmp_path.chmod(0o755)
    with live_stage(tmp_path) as robot:
        deployment = robot.client.deployment
        robot.signal(AWAY, signal.SIGKILL)
        paths = [socket_path(deployment.listen(name)) for name in (AWAY, "safety", "hal")]
        words = [sys.executable, "-c", TRIES]
        nobody = subprocess.run([*words, str(NOBODY), *paths], stdout=subprocess.PIPE, check=True)
        found = json.loads(nobody.stdout)
        assert found == dict.fromkeys(found, "PermissionError") and len(found) == 6
        robot.client.gate_status()
        root = subprocess.run([*words, "0", *paths], stdout=subprocess.PIPE, check=True)
        assert json.loads(root.stdout)["dial"] == "done", "who may does"


def reaches(robot: LiveStage) -> bool:
    return {"hal", "safety", "runner"} <= set(robot.client.alive)


@pytest.mark.processes
@pytest.mark.timeout(240)
def test_where_the_path_is_too_long_services_meet_by_a_short_link(
    far: Path, tmp_path: Path
) -> None:
    with live_stage(tmp_path / "stage") as robot:
        paths = [Path(socket_path(one)) for one in robot.client.deployment.tool_endpoints().connect]
        links = {path.parent for path in paths}
        assert all(path.is_socket() for path in paths) and reaches(robot)
        [link] = links
        assert link.is_symlink() and link.resolve().is_relative_to(far)
    assert not link.is_symlink(), "it went with the deployment"


def test_nobody_can_make_a_socket_look_taken_by_a_socket_of_theirs() -> None:
    """Each socket's name stands in a line of /proc/net/unix, line breaks and all."""
    with tempfile.TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX) as forger:
        path = f"{folder}/free"
        line = f"0: 2 0 00010000 1 1 {os.fstat(forger.fileno()).st_ino} {path}\n"
        forger.bind(f"\0\n{line}")
        forger.listen()
        assert f"\n{line}" in Path("/proc/net/unix").read_text(errors="replace")
        assert not is_listening(path) and listener_of(path) is None


def test_who_listens_is_known_until_it_ends_whatever_is_left_of_it(tmp_path: Path) -> None:
    path = str(tmp_path / "its.sock")
    assert not is_listening(path)
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(path)
        assert not is_listening(path)
        one.listen(0)
        assert listener_of(path) == os.getpid()
        assert all(is_listening(path) for _ in range(3)), "it need not accept anybody"
    assert Path(path).is_socket() and not is_listening(path) and listener_of(path) is None


@pytest.mark.parametrize("odd", ["line\nbreak", "no text\udcff", "?", "#"])
def test_signs_that_no_endpoint_has_are_left_to_a_link(
    odd: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(ACCESS_VARIABLE, str(tmp_path / odd))
    link = path_of(ONE, "hal").parent
    assert link.is_symlink() and link.resolve() == tmp_path.resolve() / odd / "one" / "sockets"
    forget_sockets(ONE)


@pytest.mark.parametrize("name", ["hal", "a" * 64])
def test_no_folder_and_no_name_makes_a_path_that_the_kernel_refuses(far: Path, name: str) -> None:
    path = path_of(ONE, name)
    assert len(os.fsencode(path)) <= LONGEST_PATH - len(str(2**32)) + len(str(os.getuid()))
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(path))
    assert (access_dir(ONE) / "sockets" / f"{name}.sock").is_socket()
    with closing(ZenohBus(Endpoints(listen=[socket_endpoint(ONE, name)]))):
        pass


def test_a_link_to_what_was_deleted_goes_with_the_next(far: Path) -> None:
    gone, kept = path_of(Keys("gone"), "hal").parent, path_of(ONE, "hal").parent
    shutil.rmtree(far / "gone")
    path_of(Keys("next"), "hal")
    assert not gone.is_symlink() and kept.is_symlink()
    forget_sockets(Keys("next"))


@pytest.mark.usefixtures("far")
@pytest.mark.parametrize("wrong", ["a link", "open to others", "another's"])
def test_a_folder_of_short_links_that_others_could_have_made_is_refused(
    wrong: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    short = tmp_path / "short"
    monkeypatch.setattr("fairlead.deploy.sockets.SHORT", str(short))
    if wrong == "a link":
        (tmp_path / "elsewhere").mkdir(mode=0o700)
        Path(f"{short}-{os.getuid()}").symlink_to(tmp_path / "elsewhere")
    else:
        Path(f"{short}-{os.getuid()}").mkdir(mode=0o755 if wrong == "open to others" else 0o700)
    if wrong == "another's":
        if os.getuid():
            pytest.skip("only root can give folders away")
        os.chown(f"{short}-{os.getuid()}", NOBODY, -1)
    with pytest.raises(ConfigError, match=rf"^access: {short}-{os.getuid()}: expected [^\n]*$"):
        socket_endpoint(ONE, "hal")


def test_a_folder_that_others_can_enter_is_refused(access: Path) -> None:
    folder = path_of(ONE, "hal").parent
    folder.chmod(0o755)
    said = f"^access: {folder}: expected mode 700 of this user [^\n]*got 755[^\n]*$"
    with pytest.raises(ConfigError, match=said):
        socket_endpoint(ONE, "hal")


def test_robots_namespaces_and_folders_of_credentials_never_meet(
    access: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = [ONE, Keys("other"), Keys("one", "lab")]
    paths = [path_of(keys, "hal") for keys in names]
    for text in (f"{access}2", f"{access}{'x' * 120}", f"{access}{'y' * 120}"):
        monkeypatch.setenv(ACCESS_VARIABLE, text)
        paths += [path_of(keys, "hal") for keys in names]
        for keys in names:
            forget_sockets(keys)
    assert len(set(paths)) == len(paths) == 12


@pytest.mark.usefixtures("access")
def test_where_access_is_open_a_service_has_a_port_if_the_file_says_so() -> None:
    spec = yaml.safe_load(FILE.read_text(encoding="utf-8")) | {"access": "open"}
    spec["services"]["hal"]["listen"] = "tcp/127.0.0.1:7501"
    gate = Deployment.model_validate(spec).endpoints("safety")
    own = socket_endpoint(Keys("panda_mobile"), "safety")
    assert (gate.listen, gate.connect, gate.access) == ([own], ["tcp/127.0.0.1:7501"], {})


@pytest.mark.processes
def test_a_service_that_starts_with_umask_0_makes_a_folder_for_itself_alone(access: Path) -> None:
    words = fairlead_command("service", str(FILE), "hal")
    environment = os.environ | {"HOME": str(access.parent), "FAIRLEAD_STATE": str(access.parent)}
    socket_of = access / "panda_mobile" / "sockets" / "hal.sock"
    with subprocess.Popen(words, env=environment, umask=0, stdout=subprocess.DEVNULL) as hal:
        try:
            wait_for(socket_of.is_socket, "it listens", 60.0)
        finally:
            hal.kill()
    assert oct(socket_of.parent.stat().st_mode & 0o777) == "0o700"


LISTENS = """
import json, sys, time
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
bus = ZenohBus(Endpoints(listen=[sys.argv[1]]))
print("listens", flush=True)
time.sleep(1000)
"""


@pytest.mark.processes
def test_what_a_killed_service_left_is_taken_over_and_a_living_ones_is_not(access: Path) -> None:
    endpoint = socket_endpoint(ONE, "hal")
    with closing(ZenohBus(Endpoints(connect=[endpoint]))) as peer:
        for _ in range(2):
            with subprocess.Popen(
                [sys.executable, "-c", LISTENS, endpoint], stdout=subprocess.PIPE, text=True
            ) as one:
                assert one.stdout is not None and one.stdout.readline() == "listens\n"
                wait_for(lambda: len(peer.peers) == 1, "they meet", 10.0)
                with pytest.raises(TransportError, match="in use by another process; see which"):
                    ZenohBus(Endpoints(listen=[endpoint]))
                one.kill()
            assert Path(socket_path(endpoint)).is_socket(), "it is left over"
            wait_for(lambda: not peer.peers, "it is gone", 10.0)


@pytest.mark.processes
def test_two_deployments_of_one_file_and_two_folders_do_not_meet(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    buses = []
    for name in ("left", "right"):
        monkeypatch.setenv(ACCESS_VARIABLE, str(tmp_path / name))
        deployment = load_deployment(FILE)
        buses += [ZenohBus(deployment.endpoints(one)) for one in ("hal", "safety")]
    try:
        wait_for(lambda: all(bus.peers for bus in buses), "each gate has its HAL", 10.0)
        assert [len(bus.peers) for bus in buses] == [1, 1, 1, 1]
    finally:
        for bus in buses:
            bus.close()
