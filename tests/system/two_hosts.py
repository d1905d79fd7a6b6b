"""A deployment on two hosts, run as its users do, by the commands at its top, on each."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import wait_for
from bench.equipment.motion_log import MotionLog
from fairlead.paths import ACCESS_VARIABLE, STATE_VARIABLE, repo_root
from fairlead_tools.cli.service import router_command
from fairlead_tools.supervisor.this_host import free_ports
from tests.system.two_networks import HOSTS, TwoNetworks

SOURCE = repo_root() / "compose" / "panda_mobile_two_hosts.yaml"
MAKE, *UPS, RUN = re.findall(r"^#   (fairlead .*?)  +#", SOURCE.read_text(encoding="utf-8"), re.M)
"""What a person types: on the robot's host, on the GPU host, on either."""
COPY = (
    "rsync -a --mkpath ~/.local/state/fairlead/access/panda_mobile/certificates/gpu/ "
    "192.168.1.20:.local/state/fairlead/access/panda_mobile/certificates/gpu/"
)
"""What ``certs new`` has printed."""
SKILL = "oracle-counter-to-cabinet"
COMMAND_S = 120.0
END_S = 20.0


class TwoHosts:
    """Both hosts' ``fairlead up``, each with its own copy of the file and its own state.

    Args:
        folder: gets a folder for each host.
        pacing: ``lockstep`` (with traces), or ``realtime``, with a HAL that computes no physics:
            a busy machine must not be taken for a cut link.
        zenohd: Zenoh's own router, in the place of ours; None for ours.
        cameras: of the simulated robot; in lockstep only.
    """

    def __init__(
        self,
        network: TwoNetworks,
        folder: Path,
        pacing: str,
        zenohd: Path | None = None,
        cameras: Sequence[Mapping[str, object]] = (),
    ) -> None:
        self.network, self._folder, self._zenohd = network, folder, zenohd
        self._id = f"hosts{os.getpid()}"
        content = yaml.safe_load(SOURCE.read_text(encoding="utf-8"))
        content |= {"hosts": network.addresses, "pacing": pacing, "id": self._id}
        content["router"]["port"] = free_ports(1)[0]
        if pacing == "realtime":
            content["services"]["hal"] = {**LIGHT_HAL, "host": "robot"}
        else:
            for name in ("hal", "runner"):
                content["services"][name]["options"]["trace"] = True
            content["services"]["hal"]["options"]["cameras"] = list(cameras)
        for host in HOSTS:
            self._file(host).parent.mkdir(parents=True)
            self._file(host).write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
        self._ups: dict[str, subprocess.Popen[bytes]] = {}
        self._copy_certificates(self._typed("robot", MAKE))
        self.motion = MotionLog(self.state_of("robot", "hal"))

    def _copy_certificates(self, printed: str) -> None:
        """Do what ``certs new`` says, between two folders of this machine."""
        here, there = (
            self._folder / host / "state" / "access" / self._id / "certificates" / "gpu"
            for host in HOSTS
        )
        shown = COPY.replace("192.168.1.20", self.network.addresses["gpu"])
        shown = re.sub(r"(~/)?\.local/state/fairlead/access/panda_mobile/\S+", f"{here}/", shown)
        assert f"  {shown}\n" in printed
        shutil.copytree(here, there)

    def state_of(self, host: str, service: str) -> Path:
        """A service's own state folder."""
        return self._folder / host / "state" / f"{self._id}:{host}" / service

    def printed(self, host: str) -> str:
        """What ``fairlead up`` has printed on a host so far."""
        return (self._folder / host / "up.log").read_text(encoding="utf-8")

    # --- the hosts -------------------------------------------------------------------

    def up(self, host: str) -> None:
        """Start a host."""
        [line] = [line for line in UPS if line.endswith(f"--host {host}")]
        if self._zenohd and host == "robot":
            self._start_zenohd(self._zenohd)
            line += " --without router"
        with (self._folder / host / "up.log").open("wb") as log:
            self._ups[host] = subprocess.Popen(
                self._words(host, *self._arguments(host, line)),
                env=self._environment(host),
                stdout=log,
                stderr=subprocess.STDOUT,
            )

    def _start_zenohd(self, program: Path) -> None:
        """As ``fairlead router --help`` says, with what ``--print-config`` prints."""
        config = self._folder / "router.json"
        printed = self.tell("robot", "router", str(self._file("robot")), "--print-config")
        config.write_text(printed, encoding="utf-8")
        said = " ".join((router_command.__doc__ or "").split())
        [runtime] = re.findall(r'ZENOH_RUNTIME="(.*?)"', said)
        with (self._folder / "zenohd.log").open("wb") as log:
            self._ups["zenohd"] = subprocess.Popen(
                [*self.network.on("robot"), program, "--config", config],
                env=self._environment("robot") | {"ZENOH_RUNTIME": runtime},
                stdout=log,
                stderr=subprocess.STDOUT,
            )

    def wait_printed(self, host: str, text: str, start: int = 0) -> None:
        """Wait until ``fairlead up`` has printed something, behind ``start`` characters."""

        def is_there() -> bool:
            assert self._ups[host].poll() is None, self.printed(host)
            return text in self.printed(host)[start:]

        wait_for(is_there, f"{host} prints {text!r}", COMMAND_S)

    def end(self, host: str) -> None:
        """Ask a host to end, and wait for it."""
        self._ups[host].terminate()
        assert self._ups.pop(host).wait(END_S) == 0, self.printed(host)

    def close(self) -> None:
        """Leave nothing behind, whatever the test did."""
        for host, process in self._ups.items():
            process.terminate()
            try:
                process.wait(END_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                print(f"killed fairlead up on {host}")
        self._ups.clear()

    # --- tools -----------------------------------------------------------------------

    def start(self, host: str, *arguments: str) -> subprocess.Popen[str]:
        """Start a command on a host."""
        return subprocess.Popen(
            self._words(host, *arguments),
            env=self._environment(host),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def ask(self, host: str, *arguments: str) -> Any:
        """Run a command with ``--json`` on a host; what it printed."""
        return json.loads(self.tell(host, *arguments, "--json"))

    def tell(self, host: str, *arguments: str) -> str:
        """Run a command on a host; what it printed."""
        process = self.start(host, *arguments)
        out, err = process.communicate(timeout=COMMAND_S)
        assert process.returncode == 0, f"{arguments} on {host}: {out}\n{err}"
        return out

    def _typed(self, host: str, line: str) -> str:
        """Run a line of the guide on a host; what it printed."""
        return self.tell(host, *self._arguments(host, line))

    def _arguments(self, host: str, line: str) -> list[str]:
        """What stands behind ``fairlead`` in a line of the guide, with the file of this test."""
        program, *words = line.split()
        assert program == "fairlead", line
        return [str(self._file(host)) if word == f"./{SOURCE.name}" else word for word in words]

    def pid(self, host: str, service: str) -> int:
        """Process number of a service, from ``fairlead ps`` there."""
        (entry,) = self.ask(host, "ps")
        return int(entry["services"][service]["process"]["pid"])

    def _words(self, host: str, *arguments: str) -> list[str]:
        return [*self.network.on(host), sys.executable, "-m", "fairlead_tools.cli.main", *arguments]

    def _environment(self, host: str) -> dict[str, str]:
        state = self._folder / host / "state"
        own = {STATE_VARIABLE: str(state), ACCESS_VARIABLE: str(state / "access")}
        return os.environ | own | {"COLUMNS": "200", "TERM": "dumb", "NO_COLOR": "1"}

    def _file(self, host: str) -> Path:
        return self._folder / host / "deployment.yaml"


@contextmanager
def two_hosts(
    network: TwoNetworks,
    folder: Path,
    pacing: str,
    zenohd: Path | None = None,
    cameras: Sequence[Mapping[str, object]] = (),
) -> Iterator[TwoHosts]:
    """Both hosts, the one without the router first, until every service is there."""
    hosts = TwoHosts(network, folder, pacing, zenohd, cameras)
    try:
        hosts.up("gpu")
        hosts.wait_printed("gpu", "waiting: router ")
        hosts.up("robot")
        for host in HOSTS:
            hosts.wait_printed(host, " is up; state and logs: ")
        yield hosts
    finally:
        hosts.close()
