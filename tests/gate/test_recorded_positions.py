"""What ``fairlead robot distances`` reads out of a gate's decision log."""

from __future__ import annotations

import json
import re
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.gate_scene import Scene
from fairlead.errors import ConfigError
from fairlead.messages import JointState, encode, pack_floats
from fairlead.robot.manifest import load_robot
from fairlead_tools.shape.recorded_positions import recorded_positions
from tests.cli.command import fairlead_here as fairlead
from tests.gate.decision_logs import logs

ROBOT = load_robot("panda_mobile")
WIDTH = 14


def state(tick: int, width: int = WIDTH) -> bytes:
    """A joint state whose positions are its tick."""
    still = pack_floats(np.zeros(width))
    return encode(
        JointState(
            session=7, tick=tick, episode_tick=1, stamp_ns=0, efforts=still, velocities=still,
            positions=pack_floats(np.full(width, float(tick))), acted=(), robot_hash=b"h" * 32,
        )
    )  # fmt: skip


def written(path: Path, *payloads: bytes, kind: int = 1) -> Path:
    """A log of steps that were given these, laid out as `fairlead_tools.record.run_log` says."""
    data, seal = b"fairlead-decisions-2\n", zlib.crc32(b"fairlead-decisions-2\n")
    for payload in payloads:
        body = struct.pack("<QQIBB3sI", 1, 2, 9, kind, 3, b"who", len(payload)) + payload + b"\0\0"
        head = struct.pack("<I", len(body) << 8 | 3)
        head += bytes([head[0] ^ head[1] ^ head[2] ^ head[3] ^ 0xA5])
        seal = zlib.crc32(head + body, seal)
        data += head + body + struct.pack("<I", seal)
    path.write_bytes(data)
    return path


def test_each_tick_counts_once_and_what_is_no_joint_state_not_at_all(tmp_path: Path) -> None:
    log = written(tmp_path / "a", state(1), state(2), state(2), b"nonsense", state(5))
    assert recorded_positions(ROBOT, log).tolist() == [[t] * WIDTH for t in (1.0, 2.0, 5.0)]
    with pytest.raises(ConfigError, match="holds no joint state"):
        recorded_positions(ROBOT, written(tmp_path / "b", state(1), kind=2))


@pytest.mark.parametrize("damage", ["cut short", "a byte changed"])
def test_a_log_counts_up_to_its_damage(damage: str, tmp_path: Path) -> None:
    log = written(tmp_path / "a", state(1), state(2), state(3))
    data = bytearray(log.read_bytes())
    if damage == "cut short":
        del data[-1]
    else:
        data[-20] ^= 1
    log.write_bytes(data)
    assert recorded_positions(ROBOT, log)[:, 0].tolist() == [1.0, 2.0]


def test_other_files_and_other_robots_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be read: No such file"):
        recorded_positions(ROBOT, tmp_path / "none")
    (tmp_path / "text").write_text("hello\n")
    with pytest.raises(ConfigError, match="is no decision log of this version"):
        recorded_positions(ROBOT, tmp_path / "text")
    log = written(tmp_path / "a", state(1, width=10))
    with pytest.raises(
        ConfigError, match=re.escape("expected 14 joints of panda_mobile, got [10]")
    ):
        recorded_positions(ROBOT, log)


@pytest.mark.processes
def test_the_command_reads_what_a_gate_wrote(scene: Scene, tmp_path: Path) -> None:
    scene.ready_to_move()
    elbow = scene.hal.joints.index("panda_joint4")
    scene.hal.positions[elbow] -= 0.2
    ticks = scene.next_tick()
    scene.silence()
    assert scene.gate.stop() == 0
    log = logs(scene)[-1]
    measured = recorded_positions(ROBOT, log)
    assert len(measured) == ticks
    assert measured[-1].tolist() == scene.hal.positions.tolist()
    done = fairlead("robot", "distances", "panda_mobile", str(log), "--json", state=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = json.loads(done.stdout)
    assert [row["least_m"] for row in rows] == sorted(row["least_m"] for row in rows)
    assert {"panda_link3", "panda_link5"} in [set(row["links"]) for row in rows]
    folder = str(log.parent)  # whose newest log it is
    text = fairlead("robot", "distances", "panda_mobile", folder, state=tmp_path).stdout
    assert f"pairs over {ticks} recorded states of panda_mobile" in text
