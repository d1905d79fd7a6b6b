"""What ``fairlead teleop --device so101`` refuses before it touches a robot."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.command import fairlead_here


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (("--device", "so101"), "--device so101 needs the leader's --port, as /dev/ttyACM1"),
        (("--port", "/dev/ttyACM1"), "teleop: --port: expected --device so101 with it, got"),
        (("--device", "so101", "-d", "panda_mujoco"), "joint_position (valid: so101)"),
        (("--device", "so101", "--part", "gripper"), "got gripper of so101 in joint_position"),
    ],
)
def test_what_does_not_fit_is_refused(words: tuple[str, ...], wanted: str, tmp_path: Path) -> None:
    where = () if "-d" in words else ("-d", "so101_mujoco")
    refused = fairlead_here("teleop", *where, *words, state=tmp_path)
    assert refused.returncode != 0 and wanted in refused.stderr
    assert len(refused.stderr.splitlines()) == 1
