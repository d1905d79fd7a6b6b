"""Who is revoked stays out, whatever becomes of the rest and of the deployment file."""

from __future__ import annotations

import errno
import json
import re
import subprocess
from datetime import timedelta
from pathlib import Path

import pytest

from bench.equipment.live_robot import wait_for
from fairlead.deploy.access_warnings import access_warnings
from fairlead.deploy.credentials import alone_in
from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError
from fairlead_tools.certificates.authority import Authority
from tests.access.certified import DAYS, NOW, trusted
from tests.cli.command import fairlead_command, fairlead_environment, fairlead_here


def test_what_follows_a_revocation_may_fail_and_a_host_may_be_new(
    authority: Authority, deployment: Deployment
) -> None:
    every = trusted(authority)
    hosts = {**deployment.hosts, "gpu2": "127.0.0.3"}
    more = Authority(deployment.model_copy(update={"hosts": hosts}))
    more.revoke([("gpu", "runner")])
    assert every - trusted(authority) == {"CN=signs gpu/runner,OU=gpu,O=fl/certified"}
    assert more.places([]) == [p for p in deployment.certified if p != ("gpu", "runner")]
    more.renew(more.places([]), NOW, DAYS)


def test_a_certificate_that_was_not_written_is_made_with_the_key_that_signs(
    authority: Authority,
) -> None:
    every = trusted(authority)
    (authority.folder / "gpu/runner.pem").unlink()
    assert authority.new(NOW, DAYS) == [("gpu", "runner")]
    assert trusted(authority) == every


def test_one_that_its_key_did_not_sign_or_that_is_damaged_is_made_anew(
    authority: Authority, deployment: Deployment
) -> None:
    runner, hal = (authority.folder / one for one in ("gpu/runner.pem", "robot/hal.pem"))
    earlier = hal.read_bytes()
    authority.revoke([("robot", "hal")])
    assert authority.new(NOW, DAYS) == [("robot", "hal")]
    hal.write_bytes(earlier)  # copied back from another host, say
    with pytest.raises(ConfigError, match=r"signed by nobody whom the router lets in; copy .* new"):
        deployment.endpoints("hal")
    runner.write_bytes(runner.read_bytes()[:300])
    assert authority.new(NOW, DAYS) == [("robot", "hal"), ("gpu", "runner")]
    deployment.endpoints("hal")


@pytest.mark.processes
def test_who_revokes_waits_for_whoever_makes_certificates(
    authority: Authority, file: Path, tmp_path: Path
) -> None:
    every, words = trusted(authority), ["certs", "revoke", str(file), "gpu"]
    with alone_in(authority.folder.parent):
        revoking = subprocess.Popen(fairlead_command(*words), env=fairlead_environment(tmp_path))
        wait_for(lambda: is_waiting(revoking.pid), "it waits")
        assert trusted(authority) == every
    assert revoking.wait(60.0) == 0
    assert len(trusted(authority)) == len(every) - 2


def is_waiting(process: int) -> bool:
    """For somebody else's lock."""
    locks = Path("/proc/locks").read_text(encoding="ascii").splitlines()
    return any("->" in one and str(process) in one.split() for one in locks)


def test_a_host_that_left_the_file_is_revoked_and_comes_back_with_other_keys(
    authority: Authority, deployment: Deployment, file: Path, tmp_path: Path
) -> None:
    hosts = {**deployment.hosts, "laptop": "127.0.0.3"}
    wider = Authority(deployment.model_copy(update={"hosts": hosts}))
    laptop = ("laptop", "operator")
    assert wider.new(NOW, DAYS) == [laptop]
    before = (authority.folder / "laptop/operator.pem").read_text()
    every = trusted(authority)
    assert authority.places(["laptop"], left=True) == [laptop] == authority.left
    with pytest.raises(ConfigError, match="expected a host or name, got laptop"):
        authority.places(["laptop"])
    said = fairlead_here("certs", "new", str(file), state=tmp_path).stdout
    assert "revoked what the file names no more: laptop/operator" in said
    assert "fairlead restart router" in said
    assert every - trusted(authority) == {"CN=signs laptop/operator,OU=laptop,O=fl/certified"}
    assert not (authority.folder / "laptop/operator.pem").exists()
    assert wider.new(NOW, DAYS) == [laptop]
    assert (authority.folder / "laptop/operator.pem").read_text() != before


@pytest.mark.parametrize("kept", [0, 100, 300])
def test_a_damaged_key_that_signs_is_named_and_revoked_with_others(
    authority: Authority, file: Path, tmp_path: Path, kept: int
) -> None:
    every = trusted(authority)
    signs = authority.folder.parent / "signing/robot.hal.pem"
    signs.write_bytes(signs.read_bytes()[:kept])
    for command in ("new", "renew", "revoke"):
        names = ["gpu"] if command == "revoke" else []
        done = fairlead_here("certs", command, str(file), *names, state=tmp_path)
        assert done.returncode == 1
        assert done.stderr.startswith(f"ERROR {signs}: the key that signs for robot/hal is damaged")
        assert trusted(authority) == every
    fairlead_here("certs", "revoke", str(file), "gpu", "robot/hal", state=tmp_path)
    gone = {one for one in every if "OU=gpu" in one or "robot/hal," in one}
    assert every - trusted(authority) == gone and len(gone) == 3
    authority.new(NOW, DAYS)
    assert len(trusted(authority)) == len(every)


def test_a_disk_that_fills_while_one_is_revoked_forgets_nobody(
    authority: Authority, deployment: Deployment, monkeypatch: pytest.MonkeyPatch
) -> None:
    hosts = {**deployment.hosts, "laptop": "127.0.0.3"}
    Authority(deployment.model_copy(update={"hosts": hosts})).new(NOW, DAYS)

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("fairlead_tools.certificates.authority.write_private", full)
        with pytest.raises(OSError, match="No space"):
            authority.new(NOW, DAYS)
    assert authority.left == [("laptop", "operator")]


def test_nothing_is_renewed_where_nothing_was_made(deployment: Deployment) -> None:
    with pytest.raises(ConfigError, match="no certificates; make them: fairlead certs new"):
        Authority(deployment).places([])
    with pytest.raises(ConfigError, match="gpu/runner: has no certificate; make it: fairlead"):
        Authority(deployment).renew([("gpu", "runner")], NOW, DAYS)


def test_show_tells_whom_the_router_lets_in_by_a_mark_of_its_own(
    authority: Authority, file: Path, tmp_path: Path
) -> None:
    def marked() -> str:
        said = fairlead_here("certs", "show", str(file), state=tmp_path).stdout
        return re.sub(r"\s+", " ", said).partition("started again: mark ")[2]

    before = marked()
    assert re.match("[0-9a-f]{12}", before)
    authority.revoke([("gpu", "runner")])
    assert re.match("[0-9a-f]{12}", marked()) and marked() != before


@pytest.mark.parametrize("which", ["robot/hal", "robot/router", "gpu/runner"])
def test_show_and_status_tell_of_a_certificate_that_nobody_here_trusts(
    authority: Authority, deployment: Deployment, file: Path, tmp_path: Path, which: str
) -> None:
    before = fairlead_here("certs", "show", str(file), state=tmp_path)
    assert (before.returncode, before.stderr) == (0, "")
    mine = authority.folder / f"{which}.pem"
    kept = mine.read_text()
    host, name = which.split("/")
    authority.revoke([(host, name)])
    authority.new(NOW, DAYS)  # by a signer of the same name
    mine.write_text(kept)
    said = fairlead_here("certs", "show", str(file), state=tmp_path)
    assert said.returncode == 1
    shown = fairlead_here("certs", "show", str(file), "--json", state=tmp_path)
    states = {f"{one['host']}/{one['name']}": one["state"] for one in json.loads(shown.stdout)}
    wrong = {name: state for name, state in states.items() if state != "valid"}
    assert shown.returncode == 1 and list(wrong) == [which]
    assert re.match("is signed by nobody whom (the router lets in|the hosts trust);", wrong[which])
    assert wrong[which] in said.stdout
    assert access_warnings(deployment) == [f"certificate of {which} {wrong[which]}"]


def test_show_ends_with_one_where_one_has_ended(
    authority: Authority, file: Path, tmp_path: Path
) -> None:
    authority.renew([("robot", "hal")], NOW - timedelta(days=400), DAYS)
    said = fairlead_here("certs", "show", str(file), state=tmp_path)
    assert said.returncode == 1 and " ended " in said.stdout
