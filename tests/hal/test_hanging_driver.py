"""A driver's call that never returns: systemd hears no more of the HAL, and starts it again."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

pytestmark = pytest.mark.processes

WATCHDOG_S = 0.4
"""After so long without a word systemd ends it."""
START_S = 60.0
MANY = 40
HAL = """
import threading
from pathlib import Path
from fairlead.hal.process import Equipment, run_hal
from fairlead.service import run_service
from fairlead_hal_kinematic.kinematic_backend import KinematicBackend

class Driver(KinematicBackend):
    def read(self):
        if Path("hang").exists():
            print("hangs", flush=True)
            threading.Event().wait()
        return super().read()

def equip(robot):
    return Equipment(Driver(robot))

raise SystemExit(run_service("driver", lambda context: run_hal(context, equip, what="driver")))
"""


def test_a_hal_whose_driver_hangs_says_no_more_that_it_goes_on(tmp_path: Path) -> None:
    services = {"hal": {"run": "hal_kinematic"}}
    robot = {"robot": "panda", "id": f"hangs{os.getpid()}", "pacing": "realtime"}
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(robot | {"services": services}))
    (tmp_path / "hal.py").write_text(HAL)
    words = ["hal.py", "--deployment", "robot.yaml", "--service", "hal", "--state-dir", "state"]
    told = {"NOTIFY_SOCKET": str(tmp_path / "notify"), "WATCHDOG_USEC": f"{WATCHDOG_S * 1e6:.0f}"}
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(told["NOTIFY_SOCKET"])
        manager.settimeout(START_S)
        with subprocess.Popen(
            [sys.executable, *words], cwd=tmp_path, env=os.environ | told, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        ) as hal:  # fmt: skip
            try:
                while manager.recv(100) != b"READY=1":
                    pass
                assert [manager.recv(100) for _ in range(8)] == [b"WATCHDOG=1"] * 8
                (tmp_path / "hang").touch()
                assert hal.stdout is not None
                assert any(line.endswith("hangs\n") for line in hal.stdout)
                manager.settimeout(10 * WATCHDOG_S)
                with pytest.raises(TimeoutError):
                    for _ in range(MANY):
                        manager.recv(100)
                hal.terminate()
                assert "did not end within" in hal.stdout.read(), "its event loop went on"
            finally:
                hal.kill()
