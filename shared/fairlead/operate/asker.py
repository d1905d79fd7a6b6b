"""Who asks a service: a person, by whose name it logs what it was told."""

from __future__ import annotations

import getpass
import os
import socket

from fairlead.deploy.access import OPERATOR
from fairlead.deploy.certificates import certified_host
from fairlead.deploy.deployment import Deployment
from fairlead.keys import check_name

OPERATOR_VARIABLE = "FAIRLEAD_OPERATOR"
"""Names the person where several share a user of the machine."""


def asker(deployment: Deployment, program: str) -> str:
    """``ada@lab (fairlead run)``: what a program says of itself; nobody proves it.

    The host is that of the certificate by which tools have a link here, else the machine's name.

    Raises:
        ConfigError: FAIRLEAD_OPERATOR is no name.
    """
    hosts = [host for host, name in deployment.certified if name == OPERATOR]
    host = certified_host(deployment.keys, hosts, OPERATOR) or socket.gethostname()
    return f"{check_person()}@{host} ({program})"


def check_person() -> str:
    """Who sits here: FAIRLEAD_OPERATOR, else the user; raises `ConfigError` if that is no name."""
    named = os.environ.get(OPERATOR_VARIABLE)
    if named is not None:
        return check_name(OPERATOR_VARIABLE, named)
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a user without a name, as in a container
        return f"user-{os.getuid()}"
