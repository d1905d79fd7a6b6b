"""Units for systemd: each process of a host by itself, watched, and with few rights."""

from __future__ import annotations

import re
import sys
from collections.abc import Container, Mapping, Sequence
from pathlib import Path

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.shared_router import check_shared
from fairlead.errors import ConfigError, expected

WATCHDOG_S = 10
"""A process that has said nothing for so long is killed and started again: the robot holds."""
START_S = 120
STOP_S = 15

_TARGET = """\
[Unit]
Description=fairlead {id}: all services of {host}
After=network-online.target
Wants=network-online.target

[Install]
WantedBy=multi-user.target
"""

_SERVICE = """\
[Unit]
Description=fairlead {id}: {name}
{part_of}After=network-online.target
StartLimitIntervalSec=0

[Service]
Type=notify
ExecStart={command}
User={user}
Environment=HOME=%S/fairlead-{home}
StateDirectory=fairlead-{home}
StateDirectoryMode=0700
UMask=0077
Restart=always
RestartSec=1
WatchdogSec={watchdog}
WatchdogSignal=SIGKILL
TimeoutStartSec={start}
TimeoutStopSec={stop}
OOMScoreAdjust={oom}
LimitRTPRIO=99
LimitCORE=0

NoNewPrivileges=yes
CapabilityBoundingSet=
AmbientCapabilities=
ProtectSystem=strict
ProtectHome=read-only
PrivateTmp=yes
ProtectProc=invisible
ProtectClock=yes
ProtectHostname=yes
ProtectKernelLogs=yes
ProtectKernelModules=yes
ProtectKernelTunables=yes
ProtectControlGroups=yes
RestrictAddressFamilies=AF_INET AF_INET6 AF_UNIX AF_NETLINK
RestrictNamespaces=yes
RestrictSUIDSGID=yes
LockPersonality=yes
RemoveIPC=yes
SystemCallArchitectures=native
SystemCallFilter=@system-service
SystemCallErrorNumber=EPERM
{more}
[Install]
WantedBy={target}
"""

_USER = re.compile(r"[a-z_][a-z0-9_-]{0,30}")
_NO_DEVICES = "PrivateDevices=yes\nDevicePolicy=closed\n"
_NO_OWN_CODE = "MemoryDenyWriteExecute=yes\n"
"""But for the gate, everything compiles as it runs: numba, jax, drivers of a GPU."""


def systemd_units(
    file: Path, deployment: Deployment, host: str | None, user: str, without: Container[str] = ()
) -> Mapping[str, str]:
    """Text of each unit by its file name: one for each process of a host, and what starts them all.

    None needs another one: the gate and the HAL go on whatever becomes of the rest. HALs and
    runners see the devices of the machine, which a robot or a GPU may be.

    Args:
        file: the deployment file, where it lies on that host.
        user: as whom they run.
        without: processes that get none.

    Raises:
        ConfigError: a path or the user has signs that a unit cannot have.
    """
    unit = unit_name(deployment.id, deployment.namespace)
    target = f"{unit}.target"
    units = {target: _TARGET.format(id=deployment.id, host=host or "this machine")}
    gate = deployment.only("safety")
    for name in deployment.processes(host):
        if name in without:
            continue
        more = "" if name == deployment.hal or name in deployment.runners else _NO_DEVICES
        units[f"{unit}@{name}.service"] = _service(
            deployment.id,
            name,
            ["router", file] if name == ROUTER else ["service", file, name],
            user,
            home=unit.removeprefix("fairlead-").replace(":", "+"),
            target=target,
            oom=-900 if name in (gate, deployment.hal) else 0,
            more=more + (_NO_OWN_CODE if name == gate else ""),
        )
    return units


def unit_name(robot: str, namespace: str) -> str:
    """What a robot's units begin with; names may have a hyphen, but no colon or @."""
    return f"fairlead-{robot}" if namespace == "fl" else f"fairlead-{namespace}:{robot}"


def router_unit(
    files: Sequence[Path], deployments: Sequence[Deployment], user: str
) -> Mapping[str, str]:
    """The unit of a router that several robots share, by its file name.

    Args:
        files: the deployment files, where they lie on the router's host.

    Raises:
        ConfigError: as `systemd_units`; they cannot share a router.
    """
    check_shared(deployments)
    names = ", ".join(one.id for one in deployments)
    text = _service(ROUTER, names, [ROUTER, *files], user, home=ROUTER, more=_NO_DEVICES)
    return {f"fairlead-{ROUTER}.service": text}


def _service(
    owner: str,
    name: str,
    words: Sequence[str | Path],
    user: str,
    *,
    home: str,
    more: str,
    target: str = "",
    oom: int = 0,
) -> str:
    if not _USER.fullmatch(user):
        raise ConfigError(expected("--user", "a user's name of a-z 0-9 _ -", repr(user)))
    return _SERVICE.format(
        id=owner,
        home=home,
        name=name,
        part_of=f"PartOf={target}\n" if target else "",
        target=target or "multi-user.target",
        command=_command(words),
        user=user,
        watchdog=WATCHDOG_S,
        start=START_S,
        stop=STOP_S,
        oom=oom,
        more=more,
    )


def _command(words: Sequence[str | Path]) -> str:
    program = Path(sys.executable).with_name("fairlead")
    told = [str(one.absolute()) if isinstance(one, Path) else one for one in (program, *words)]
    for word in told:
        if any(sign in word for sign in "\"'\\\n$"):
            raise ConfigError(f"unit: {word}: expected a path without quotes, \\ and $")
    return " ".join(f'"{word.replace("%", "%%")}"' for word in told)
