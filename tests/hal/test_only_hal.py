"""Two HALs of one robot: at most one goes on, whether the other answers or not."""

from __future__ import annotations

import hashlib
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from pathlib import Path

import pytest
import yaml

from bench.equipment.live_robot import wait_for
from fairlead.deploy.credentials import forget_secrets
from fairlead.deploy.process_table import process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry
from fairlead.errors import ConfigError
from fairlead.hal import one_hal
from fairlead.hal.one_hal import hold_robot, refuse_second_hal
from fairlead.keys import Keys
from fairlead.paths import user_state_dir
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.memory_bus import MemoryBus
from fairlead.wire.session import ZenohBus
from fairlead_tools.supervisor.this_host import free_ports

KEYS = Keys(f"tested{os.getpid()}")
REFUSED = f"hal: robot {KEYS.robot} already has a HAL ({{}}, which may still start or be paused); "
UNLISTED = REFUSED.format(f"process {{}} of this user (uid {os.getuid()})") + (
    f"fairlead ps does not list it, for its state folder is not {user_state_dir()}: end it where "
    "it was started"
)
BUSY_HAL = """
import threading
from fairlead.hal.process import run_hal
from fairlead.service import run_service

def equip(robot):
    print("equips", flush=True)
    threading.Event().wait()

raise SystemExit(run_service("busy", lambda context: run_hal(context, equip, what="busy")))
"""


class BusyHal:
    """A HAL process that is busy with its equipment for ever; it answers nothing.

    ports: of each service; 0: it has a socket.
    """

    def __init__(self, folder: Path, ports: dict[str, int]) -> None:
        folder.mkdir()
        (folder / "busy.py").write_text(BUSY_HAL)
        services = {
            name: {"run": "hal_kinematic"} | ({"listen": f"tcp/127.0.0.1:{port}"} if port else {})
            for name, port in ports.items()
        }
        spec = {"robot": "panda", "id": KEYS.robot, "pacing": "realtime", "services": services}
        if any(ports.values()):
            spec["access"] = "open"  # each listens on a port of its own
        (folder / "robot.yaml").write_text(yaml.safe_dump(spec, sort_keys=False))
        words = [sys.executable, str(folder / "busy.py"), "--deployment"]
        words += [str(folder / "robot.yaml"), "--service", "hal", "--state-dir", str(folder)]
        self._log = folder / "log"
        with self._log.open("wb") as log:
            self.process = subprocess.Popen(words, stdout=log, stderr=subprocess.STDOUT)

    @property
    def said(self) -> str:
        return self._log.read_text()

    @property
    def has_decided(self) -> bool:
        return "equips" in self.said or self.process.poll() is not None


@pytest.fixture
def two_busy_hals(tmp_path: Path) -> Iterator[list[BusyHal]]:
    first, second = free_ports(2)
    hals = [
        BusyHal(tmp_path / "first", {"hal": first, "other": second}),
        BusyHal(tmp_path / "second", {"other": first, "hal": second}),
    ]
    yield hals
    for hal in hals:
        hal.process.kill()
        hal.process.wait()


@pytest.mark.processes
def test_of_two_hals_that_start_together_and_answer_nothing_one_goes_on(
    two_busy_hals: list[BusyHal],
) -> None:
    wait_for(lambda: all(hal.has_decided for hal in two_busy_hals), "both have decided", 60.0)
    said = [hal.said for hal in two_busy_hals]
    assert sum("equips" in text for text in said) == 1, said
    assert sum(f"robot {KEYS.robot} already has a HAL (" in text for text in said) == 1, said


@pytest.mark.processes
def test_a_paused_hal_that_no_link_can_reach_is_named_to_a_second_on_its_host(
    tmp_path: Path,
) -> None:
    ports = free_ports(2)
    first = BusyHal(tmp_path / "first", {"hal": ports[0]})
    hals = [first]
    try:
        wait_for(lambda: first.has_decided, "the first goes on", 60.0)
        first.process.send_signal(signal.SIGSTOP)
        hals.append(BusyHal(tmp_path / "second", {"hal": ports[1]}))
        wait_for(lambda: hals[1].has_decided, "the second has decided", 60.0)
        assert UNLISTED.format(first.process.pid) in hals[1].said
        first.process.kill()
        hals.append(BusyHal(tmp_path / "third", {"hal": ports[1]}))
        wait_for(lambda: hals[2].has_decided, "the third has decided", 60.0)
        assert "equips" in hals[2].said
    finally:
        for hal in hals:
            hal.process.kill()
            hal.process.wait()


@pytest.mark.processes
def test_of_hals_that_look_at_the_same_moment_one_goes_on() -> None:
    endpoint = f"tcp/127.0.0.1:{free_ports(1)[0]}"
    buses = [ZenohBus(Endpoints(listen=[endpoint])), ZenohBus(Endpoints(connect=[endpoint]))]
    together, went_on = threading.Barrier(2), list[int]()

    def start(bus: ZenohBus, session: int) -> None:
        together.wait()
        try:
            refuse_second_hal("hal", bus, KEYS, session)
        except ConfigError as error:
            assert str(error).startswith(REFUSED.format(f"session {3 - session:016x}"))
        else:
            went_on.append(session)

    threads = [threading.Thread(target=start, args=(bus, 1 + i)) for i, bus in enumerate(buses)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for bus in buses:
        bus.close()
    assert len(went_on) == 1


@pytest.mark.parametrize("other", [1, 9])
def test_a_hal_that_stays_is_named_whoever_comes_first(
    other: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(one_hal, "GO_S", 0.0)
    bus = MemoryBus()
    bus.declare_token(KEYS.hal_session(other))
    with pytest.raises(ConfigError) as caught:
        refuse_second_hal("hal", bus, KEYS, 5)
    assert str(caught.value).startswith(REFUSED.format(f"session {other:016x}"))
    seen: list[str] = []
    bus.watch_tokens(KEYS.every_hal_session, lambda key, _: seen.append(key))
    assert seen == [KEYS.hal_session(other)]


TAKEN = """
import os, sys, hashlib, socket
user = os.getuid()
os.setresuid(65534, 65534, 65534)
held = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
held.bind("\\0fairlead-hal/" + hashlib.sha256(f"{user}/{sys.argv[1]}".encode()).hexdigest())
if "silent" not in sys.argv:
    held.listen()
print("taken", flush=True)
sys.stdin.read()
"""


HOLDS = """
import sys
from pathlib import Path
from fairlead.hal.one_hal import hold_robot
from fairlead.keys import Keys
from fairlead.paths import user_state_dir
with hold_robot("hal", Keys(sys.argv[1]), Path(sys.argv[2])):
    print("holds", flush=True)
    sys.stdin.read()
"""


@contextmanager
def saying(word: bytes, program: str, *words: str) -> Iterator[subprocess.Popen[bytes]]:
    command = [sys.executable, "-c", program, *words]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stdout.readline() == word + b"\n"
        yield process
        process.kill()
        process.communicate()


def name_taken(*how: str) -> AbstractContextManager[subprocess.Popen[bytes]]:
    return saying(b"taken", TAKEN, f"{KEYS.namespace}/{KEYS.robot}", *how)


def sockets_of(folder: Path) -> Path:
    found = folder / KEYS.robot / "sockets"
    found.mkdir(parents=True)
    return found


needs_root = pytest.mark.skipif(os.getuid() != 0, reason="only root can become another user")


@pytest.mark.processes
@needs_root
def test_another_user_who_has_taken_the_name_is_no_hal_and_is_named() -> None:
    with name_taken() as other:
        said = (
            f"^hal: robot {KEYS.robot} cannot be held for this process: process {other.pid} of "
            "another user .uid 65534. has taken its name; ask its owner, or give this robot "
            "another `id`$"
        )
        with pytest.raises(ConfigError, match=said):
            hold_robot("hal", KEYS)
    hold_robot("hal", KEYS).close()


@pytest.mark.processes
@needs_root
@pytest.mark.parametrize("how", [(), ("silent",)], ids=["listens", "silent"])
def test_where_another_user_has_the_name_one_hal_goes_on_in_a_folder_of_sockets_and_no_second(
    how: tuple[str, ...], tmp_path: Path
) -> None:
    own = sockets_of(tmp_path / "own")
    with name_taken(*how):
        with saying(b"holds", HOLDS, KEYS.robot, str(own)) as first:
            with pytest.raises(ConfigError) as caught:
                hold_robot("hal", KEYS, own)
            assert str(caught.value).startswith(UNLISTED.format(first.pid))
        hold_robot("hal", KEYS, own).close()


@pytest.mark.processes
@needs_root
def test_a_hal_s_process_starts_where_another_user_has_its_name_and_says_so(tmp_path: Path) -> None:
    with name_taken() as other:
        hal = BusyHal(tmp_path / "hal", {"hal": 0})
        try:
            wait_for(lambda: hal.has_decided, "it has decided", 60.0)
        finally:
            hal.process.kill()
            hal.process.wait()
        forget_secrets(KEYS)
    assert "equips" in hal.said
    assert f"process {other.pid} of another user (uid 65534) has taken the name" in hal.said


@pytest.mark.processes
def test_of_two_folders_and_of_one_of_them_and_none_one_goes_on(tmp_path: Path) -> None:
    with saying(b"holds", HOLDS, KEYS.robot, str(sockets_of(tmp_path / "own"))) as first:
        for folder in (None, sockets_of(tmp_path / "others")):
            with pytest.raises(ConfigError) as caught:
                hold_robot("hal", KEYS, folder)
            assert str(caught.value).startswith(UNLISTED.format(first.pid))


@pytest.mark.processes
def test_a_hal_of_which_nothing_can_be_found_out_counts_as_one(tmp_path: Path) -> None:
    """It accepts nobody: who asks waits in its queue, until that is full."""
    who = hashlib.sha256(f"{os.getuid()}/{KEYS.namespace}/{KEYS.robot}".encode()).hexdigest()
    with (
        saying(b"holds", HOLDS, KEYS.robot, str(sockets_of(tmp_path / "own"))),
        ExitStack() as waiting,
        pytest.raises(ConfigError) as caught,
    ):
        with suppress(BlockingIOError):
            while True:
                asking = waiting.enter_context(socket.socket(socket.AF_UNIX))
                asking.setblocking(False)
                asking.connect(f"\0fairlead-hal/{who}")
        hold_robot("hal", KEYS, sockets_of(tmp_path / "others")).close()
    assert str(caught.value).startswith(REFUSED.format("process unknown"))


@pytest.mark.processes
def test_of_a_hal_that_fairlead_ps_lists_its_command_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_STATE", str(tmp_path / "state"))
    with saying(b"holds", HOLDS, KEYS.robot, str(sockets_of(tmp_path / "own"))) as first:
        services = {"hal": ServiceEntry(process_id(first.pid), ready=True, restarts=0)}
        Registry().write(Running(KEYS.robot, "robot.yaml", str(tmp_path), None, services))
        with pytest.raises(ConfigError) as caught:
            hold_robot("hal", KEYS, sockets_of(tmp_path / "others"))
    advice = "see: fairlead ps, then: fairlead down"
    assert str(caught.value) == REFUSED.format(f"process {first.pid}") + advice
