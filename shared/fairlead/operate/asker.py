"""Who asks a service: a person, by whose name it logs what it was told."""

from __future__ import annotations

import getpass
import os
import socket

from fairlead.deploy.access import OPERATOR
from fairlead.deploy.certificates import certified_host
from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError, expected
from fairlead.keys import check_name
from fairlead.wire.endpoints import Endpoints

OPERATOR_VARIABLE = "FAIRLEAD_OPERATOR"
"""Names the person where several share a user of the machine."""


def asker(deployment: Deployment, program: str) -> str:
    """``ada@lab (fairlead run)``: what a program says of itself; of it only a person is proved.

    The host is that of the certificate by which tools have a link here, else the machine's name.

    Raises:
        ConfigError: as `person_here`.
    """
    hosts = [host for host, name in deployment.certified if name == OPERATOR]
    host = certified_host(deployment.keys, hosts, OPERATOR) or socket.gethostname()
    return f"{person_here(deployment) or check_person()}@{host} ({program})"


def person_here(deployment: Deployment) -> str:
    """Whose certificate tools use here: of the people that the deployment lists; "" of none.

    Of several that are here FAIRLEAD_OPERATOR's, else the user's.

    Raises:
        ConfigError: FAIRLEAD_OPERATOR is no name, or of one whose certificate is not here.
    """
    people, said = deployment.parties.people, check_person()
    here = [one for one in people if certified_host(deployment.keys, [one], one)]
    if said in here:
        return said
    if people and OPERATOR_VARIABLE in os.environ:
        who = f"{OPERATOR_VARIABLE}: deployment {deployment.id}"
        what = "a person whose certificate is here"
        raise ConfigError(expected(who, what, said, here or ["none"]))
    return here[0] if len(here) == 1 else ""


def own_endpoints(deployment: Deployment) -> Endpoints:
    """Endpoints of a tool here: with the person's certificate, else the operator's.

    Raises:
        ConfigError: as `person_here`; there is no certificate that can be used.
    """
    return deployment.tool_endpoints(person_here(deployment) or OPERATOR)


def check_person() -> str:
    """Who sits here: FAIRLEAD_OPERATOR, else the user; raises `ConfigError` if that is no name."""
    named = os.environ.get(OPERATOR_VARIABLE)
    if named is not None:
        return check_name(OPERATOR_VARIABLE, named)
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a user without a name, as in a container
        return f"user-{os.getuid()}"
