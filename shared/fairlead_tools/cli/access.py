"""``fairlead acl`` and ``certs``: who may do what on a robot's keys, and what proves names."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fairlead.deploy.access import Rights, rights
from fairlead.deploy.access_warnings import access_warnings
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.keys import Keys
from fairlead.operate.connection import choose_file
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.options import (
    DeploymentArgument,
    JsonOption,
    deployment_option,
    example,
    make_group,
)


@example("fairlead acl show panda_mujoco")
def acl_show_command(
    target: Annotated[Path | None, deployment_option()] = None,
    as_json: JsonOption = False,
) -> None:
    """Show who may write and read each key of a deployment; nobody may do anything else.

    Who writes a query asks it, who reads it answers it. EXCEPT: keys of ``KEY`` that are somebody's
    own; those have a line of their own.
    """
    deployment = load_deployment(choose_file(target))
    found = list(rights(deployment.parties))
    if as_json:
        rows = [
            {"key": r.key, "except": r.but, "kind": r.kind, "write": r.write, "read": r.read}
            for r in found
        ]
        print_json({"access": deployment.access, "rows": rows})
        return
    header = ("KEY", "KIND", "MAY WRITE", "MAY READ", "EXCEPT")
    print_table(header, [_rights_row(one) for one in found])
    if deployment.open_access:
        echo(f"\nWARNING nothing enforces this: {deployment.open_access}")


def _rights_row(one: Rights) -> tuple[str, str, str, str, str]:
    return one.key, one.kind, ", ".join(one.write), ", ".join(one.read), ", ".join(one.but)


acl_group = make_group("acl", "Show who may do what on a robot's keys.", {"show": acl_show_command})


if TYPE_CHECKING:
    from fairlead.deploy.certificates import Certificate
    from fairlead_tools.certificates.authority import Authority, Place

NamesArgument = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[NAME]...", help="a host, a service, operator or person, or gpu/operator"
    ),
]
DaysOption = Annotated[int, typer.Option("--days", min=1, max=3650, help="how long they last")]
DAYS = 365
RESTART = "on the router's host: fairlead restart router"


@example("fairlead certs new ./panda_mobile_two_hosts.yaml")
def certs_new_command(deployment: DeploymentArgument, days: DaysOption = DAYS) -> None:
    """Make the certificates that a deployment has not yet: of all its hosts, on one machine.

    The keys that sign stay on this machine.
    """
    authority = _authority(loaded := load_deployment(deployment))
    left = authority.left
    made = authority.new(datetime.now(UTC), days)
    echo(f"made {_named(made) or 'nothing: there is one for every name'}")
    if left:
        echo(f"revoked what the file names no more: {_named(left)}")
    if made or left:
        _say_what_to_copy(authority, _all_if_router(authority, made, [*made, authority.router]))
        echo(f"if it runs: {RESTART}")
    for text in access_warnings(loaded):
        echo(f"WARNING {text}")


@example("fairlead certs renew ./panda_mobile_two_hosts.yaml gpu")
def certs_renew_command(
    deployment: DeploymentArgument, names: NamesArgument = None, days: DaysOption = DAYS
) -> None:
    """Make new certificates for all names, or some; the old ones stay valid to their end."""
    authority = _authority(load_deployment(deployment))
    places = authority.places(names or [])
    authority.renew(places, datetime.now(UTC), days)
    echo(f"renewed {_named(places)}")
    _say_what_to_copy(authority, places)
    echo(f"then, when no goal runs: {RESTART}; all connect anew, with the new files")


@example("fairlead certs revoke ./panda_mobile_two_hosts.yaml gpu")
def certs_revoke_command(
    deployment: DeploymentArgument,
    names: Annotated[list[str], typer.Argument(help="as of `renew`", metavar="NAME...")],
) -> None:
    """Take certificates back: once the router starts again, it lets nobody in who shows one."""
    authority = _authority(load_deployment(deployment))
    places = authority.places(names, left=True)
    authority.revoke(places)
    echo(f"revoked {_named(places)}")
    _say_what_to_copy(authority, _all_if_router(authority, places, [authority.router]))
    echo(f"then: {RESTART}; until then they get in")
    echo("certificates with new keys for these names: fairlead certs new")


@example("fairlead certs show ./panda_mobile_two_hosts.yaml")
def certs_show_command(deployment: DeploymentArgument, as_json: JsonOption = False) -> None:
    """Show which certificates there are on this machine, when they end, and what is wrong.

    Exit status 1: one of them cannot be used.
    """
    from fairlead.deploy.certificates import every_certificate
    from fairlead_tools.certificates.authority import certified

    keys, now = (loaded := load_deployment(deployment)).keys, datetime.now(UTC)
    found = {(one.host, one.file.stem): one for one in every_certificate(keys)}
    rows = [_certificate_row(keys, place, found.get(place), now) for place in certified(loaded)]
    if as_json:
        print_json([dict(zip(("host", "name", "ends", "state"), row, strict=True)) for row in rows])
    else:
        print_table(("HOST", "NAME", "ENDS", "STATE"), rows)
        _print_marks(loaded)
    if any(found[one].problem(keys, now) for one in certified(loaded) if one in found):
        raise typer.Exit(1)


def _print_marks(loaded: Deployment) -> None:
    from fairlead.deploy.certificates import certificates_dir, trusted_mark
    from fairlead_tools.certificates.authority import certified

    keys = loaded.keys
    marks = {trusted_mark(keys, one) for one, _ in certified(loaded)} - {""}
    echo(
        f"in {certificates_dir(keys)}; mark {', '.join(sorted(marks)) or 'none'}: the same on "
        "every host"
    )
    lets_in = trusted_mark(keys, loaded.routed.host, "listen")
    if lets_in:
        echo(f"whom the router lets in, once it has started again: mark {lets_in}")


def _certificate_row(
    keys: Keys, place: Place, found: Certificate | None, now: datetime
) -> tuple[str, str, str, str]:
    if found is None:
        return *place, "", "none here"
    return *place, f"{found.ends:%Y-%m-%d %H:%M} UTC", found.warning(keys, now) or "valid"


def _authority(deployment: Deployment) -> Authority:
    from fairlead_tools.certificates.authority import Authority  # cryptography takes a moment

    return Authority(deployment)


def _named(places: Iterable[Place]) -> str:
    return ", ".join("/".join(place) for place in places)


def _all_if_router(authority: Authority, places: list[Place], else_: list[Place]) -> list[Place]:
    """Whose folders have changed: each has whom to trust as the router, the router's the others."""
    return authority.deployment.certified if authority.router in places else else_


def _say_what_to_copy(authority: Authority, changed: Iterable[Place]) -> None:
    hosts = authority.deployment.hosts
    for one in dict.fromkeys(one for one, _ in changed):
        folder = authority.folder / one
        if one not in hosts:
            echo(
                f"{one} needs, in an account that nobody else uses, at the same place below its "
                f"home, the folder {folder}: whoever can read it is {one}"
            )
            continue
        echo(f"host {one} needs, at the same place, the folder {folder}; if it is another machine:")
        echo(f"  rsync -a --mkpath {folder}/ {hosts[one]}:{folder}/")


certs_group = make_group(
    "certs",
    "Make, show, renew and revoke what proves names between hosts.",
    {
        "new": certs_new_command,
        "show": certs_show_command,
        "renew": certs_renew_command,
        "revoke": certs_revoke_command,
    },
)
