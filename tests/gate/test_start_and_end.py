"""Starting beside others, ending on request, and the command line."""

from __future__ import annotations

import hashlib
import re
import socket
import subprocess
from pathlib import Path

import pytest
from msgspec import structs

from bench.equipment.gate_scene import Scene
from bench.equipment.running_gate import RunningGate
from fairlead.errors import RefusedError
from fairlead.messages import GateState, Lease
from fairlead.paths import gate_binary
from fairlead.wire.bus import Qos
from fairlead_tools.supervisor.this_host import free_ports

pytestmark = pytest.mark.processes


def test_a_busy_port_is_named(config: Path, tmp_path: Path) -> None:
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        holder.listen()
        port = holder.getsockname()[1]
        gate = RunningGate(config, tmp_path / "state", port=port)
        assert gate.wait_exit() == 1
    assert gate.lines[-1] == (
        f"ERROR fairlead-safety: port {port} (tcp/127.0.0.1:{port}) is in use by another "
        "process; see which: fairlead ps"
    )


def test_a_busy_socket_is_named_and_a_killed_gates_is_taken_over(
    config: Path, tmp_path: Path
) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/gate.sock"
    words = [str(gate_binary()), "--robot", "r", "--config", str(config), "--listen", endpoint]
    for round_ in ("first", "after a kill"):
        with subprocess.Popen(
            [*words, "--state-dir", str(tmp_path / round_)], stdout=subprocess.PIPE, text=True
        ) as first:
            assert first.stdout is not None
            assert any(line.endswith(": ready\n") for line in first.stdout), round_
            another = [*words, "--state-dir", str(tmp_path / "another")]
            second = subprocess.run(another, capture_output=True, text=True, check=False)
            first.kill()
        assert second.returncode == 1
        assert second.stdout.endswith(
            f"ERROR fairlead-safety: its socket ({endpoint}) is in use by another process; "
            "see which: fairlead ps\n"
        )


def test_a_second_gate_for_the_same_robot_refuses_to_start(
    scene: Scene, config: Path, tmp_path: Path
) -> None:
    scene.meet_hal()
    second = RunningGate(config, tmp_path / "other", connect=[scene.gate.port])
    assert second.wait_exit() == 1
    assert second.lines[-1] == (
        "ERROR fairlead-safety: another gate already serves the robot panda_mobile; "
        "see: fairlead ps"
    )
    assert scene.status().state == GateState.DISARMED


def test_leases_of_a_gate_that_comes_later_latch_this_one(scene: Scene) -> None:
    scene.ready_to_move()
    other = scene.bus.publisher(scene.keys.lease, Lease, Qos.HOT)
    other.put(
        structs.replace(scene.leases.wait_for(lambda m: m.state == GateState.ARMED), epoch=0xBAD)
    )
    status = scene.wait_state(GateState.LATCHED)
    assert "two gates" in status.cause
    assert status.claims == ()


def test_a_forged_lease_of_its_own_epoch_latches_a_gate_and_its_own_late_ones_do_not(
    scene: Scene,
) -> None:
    scene.ready_to_move()
    forger = scene.bus.publisher(scene.keys.lease, Lease, Qos.HOT)
    newest = scene.leases.wait_for(lambda m: len(m.grants) == 1)
    for _ in range(3):
        forger.put(newest)
    assert scene.status().state == GateState.ARMED
    forger.put(structs.replace(newest, lease_seq=newest.lease_seq + 100_000))
    status = scene.wait_state(GateState.LATCHED)
    assert status.cause == (
        f"latched: two gates serve this robot: lease {newest.lease_seq + 100_000} of epoch "
        f"{newest.epoch:016x}, which this one did not send"
    )
    assert status.claims == ()


def test_refused_claims_of_many_sources_leave_room_for_an_honest_one(scene: Scene) -> None:
    scene.meet_hal()
    scene.arm()
    for number in range(70):
        with pytest.raises(RefusedError, match="robot_hash"):
            scene.claim(source=f"stranger{number}", robot_hash=bytes(32))
    assert scene.claim(source="honest").claim_id != 0


def test_a_second_gate_on_the_same_state_folder_refuses_to_start(
    scene: Scene, config: Path
) -> None:
    second = RunningGate(config, scene.state_dir)
    assert second.wait_exit() == 1
    assert "another gate already uses" in second.lines[-1]


def test_a_gate_comes_up_before_those_it_connects_to(config: Path, tmp_path: Path) -> None:
    gate = RunningGate(config, tmp_path / "state", connect=[free_ports(1)[0]])
    gate.wait_line("ready")
    assert gate.stop() == 0


def test_a_gate_has_answered_itself_before_it_is_ready(config: Path, tmp_path: Path) -> None:
    gate = RunningGate(config, tmp_path / "state")
    gate.wait_line("ready")
    assert gate.stop() == 0
    assert re.fullmatch(r"INFO safety: self-test: [1-9]\d+ known answers in \d+ us", gate.lines[0])


def test_status_names_the_configuration_by_its_hash(scene: Scene, config: Path) -> None:
    status = scene.status()
    assert status.config_hash == hashlib.sha256(config.read_bytes()).digest()
    assert (status.robot, status.profile) == ("panda_mobile", "sim")
    assert scene.status() == scene.status()


def test_a_configuration_changed_on_disk_is_not_armed(scene: Scene, tmp_path: Path) -> None:
    changed = tmp_path / "gate.json"
    changed.write_bytes(scene.config.read_bytes())
    scene.gate.stop()
    scene.config = changed
    scene.restart_gate()
    scene.meet_hal()
    changed.write_bytes(changed.read_bytes() + b"\n")
    with pytest.raises(RefusedError, match="configuration file has changed"):
        scene.arm()


def test_arming_that_cannot_be_written_down_is_refused(scene: Scene) -> None:
    scene.meet_hal()
    mark = scene.state_dir / "clean_mark"
    scene.leases.wait_for(lambda _: mark.is_file())
    mark.unlink()
    mark.mkdir()  # a mark that cannot be removed, whoever runs the test
    with pytest.raises(RefusedError, match=f"cannot remove {mark}"):
        scene.arm()
    assert scene.status().state == GateState.DISARMED


def test_the_log_names_what_happened_and_why(scene: Scene) -> None:
    scene.ready_to_move()
    scene.send(scene.chunk(epoch=scene.epoch ^ 1))
    scene.raise_stop(77)
    scene.wait_state(GateState.STOPPED)
    assert scene.gate.stop() == 0
    log = "\n".join(scene.gate.lines)
    for expected in (
        f"INFO safety: configuration {scene.config} (profile sim) hash ",
        "INFO safety: ready",
        "INFO safety: armed by test",
        "of runner for test",
        "INFO safety: chunk 1 of runner refused: G003 epoch: needs the current arm epoch",
        "INFO safety: stopped: by operator: test",
        "INFO safety: ends on SIGTERM",
    ):
        assert expected in log


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--robot"], "--robot: expected a value after it"),
        (["--speed", "1"], "unknown argument '--speed'; see: fairlead-safety --help"),
        (["judge", "LOG"], "unknown argument 'judge'; see: fairlead-safety --help"),
        ([], "--robot: missing; see: fairlead-safety --help"),
        (
            ["--robot", "A/B", "--config", "c", "--listen", "tcp/127.0.0.1:1", "--state-dir", "s"],
            "robot id: expected 1 to 64 of a-z 0-9 _ . - starting with a letter or digit, "
            "got 'A/B'",
        ),
    ],
)
def test_arguments_that_do_not_fit_are_refused(words: list[str], complaint: str) -> None:
    done = subprocess.run([gate_binary(), *words], capture_output=True, text=True, timeout=10)
    assert done.returncode == 2
    assert done.stdout == f"ERROR fairlead-safety: {complaint}\n"


def test_help_shows_an_example() -> None:
    done = subprocess.run([gate_binary(), "--help"], capture_output=True, text=True, timeout=10)
    assert done.returncode == 0
    assert "example: fairlead-safety --robot" in done.stdout
