"""What proves names between hosts: made, renewed, revoked, and refused when it must be."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from contextlib import ExitStack, closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from cryptography import x509
from cryptography.x509.oid import ExtendedKeyUsageOID

from bench.equipment.live_robot import wait_for
from fairlead.deploy.access_warnings import access_warnings
from fairlead.deploy.certificates import certified_endpoint, read_certificate
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.shared_router import router_endpoints
from fairlead.errors import ConfigError, TransportError
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.certificates.authority import Authority
from fairlead_tools.deploy.host_report import report_this
from tests.access.certified import DAYS, NOW, trusted
from tests.cli.command import fairlead_here

LONG_AGO = NOW - timedelta(days=400)
SOON = timedelta(seconds=2)
ROBOT = {"router", "hal", "safety", "state_assembler", "operator"}
GPU = {"runner", "operator"}


def names(folder: Path, pattern: str = "*.pem") -> set[str]:
    return {file.name.removesuffix(".pem") for file in folder.glob(pattern)}


def test_each_host_gets_its_own_for_this_user_alone(authority: Authority) -> None:
    assert (names(authority.folder / "robot"), names(authority.folder / "gpu")) == (ROBOT, GPU)
    assert names(authority.folder / "robot", "*.ca") == {"router.ca", "clients.ca"}
    assert names(authority.folder / "gpu", "*.ca") == {"router.ca"}
    for path in authority.folder.parent.rglob("*"):
        assert path.stat().st_mode & 0o777 == (0o700 if path.is_dir() else 0o600), path
    assert not list(authority.folder.rglob("*signing*")), "what signs is in no host's folder"


def test_a_name_is_bound_to_its_certificate_and_the_router_to_its_address(
    authority: Authority,
) -> None:
    hal, router = (read_certificate(authority.folder / f"robot/{n}.pem") for n in ("hal", "router"))
    assert (hal.name, list(hal.addresses)) == ("fl/certified/hal", [])
    assert (router.name, list(router.addresses)) == ("fl/certified/router", ["127.0.0.1"])
    assert hal.ends - NOW < timedelta(days=DAYS + 1)
    found = x509.load_pem_x509_certificate(hal.file.read_bytes())
    assert found.subject.rfc4514_string() == "CN=fl/certified/hal,OU=robot,O=fl/certified"
    [use] = found.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
    assert use == ExtendedKeyUsageOID.CLIENT_AUTH, "it is nobody's router"
    config = authority.deployment.endpoints("hal").config()
    assert set(config["transport"]["link"]) == {"tx", "rx", "tls"}
    control = config["access_control"]
    router_name = "fl/certified/router"
    assert control["subjects"] == [{"id": router_name, "cert_common_names": [router_name]}]
    assert control["default_permission"] == "deny"


def test_only_what_is_missing_is_made_anew(authority: Authority, deployment: Deployment) -> None:
    before = (authority.folder / "gpu/runner.pem").read_text()
    assert authority.new(NOW, DAYS) == []
    more = Authority(deployment.model_copy(update={"localiser": "tracker"}))
    assert more.new(NOW, DAYS) == [("robot", "tracker"), ("gpu", "tracker")]
    hosts = {**deployment.hosts, "laptop": "127.0.0.3"}
    third = Authority(deployment.model_copy(update={"hosts": hosts}))
    assert third.new(NOW, DAYS) == [("laptop", "operator")]
    assert (authority.folder / "gpu/runner.pem").read_text() == before


def test_a_revoked_one_leaves_the_list_of_the_router_and_comes_back_with_other_keys(
    authority: Authority,
) -> None:
    every, place = trusted(authority), ("gpu", "operator")
    before = (authority.folder / "gpu/operator.pem").read_text()
    authority.revoke([place])
    assert every - trusted(authority) == {"CN=signs gpu/operator,OU=gpu,O=fl/certified"}
    with pytest.raises(ConfigError, match="gpu/operator: has no certificate; make it: fairlead"):
        authority.renew([place], NOW, DAYS)
    assert authority.new(NOW, DAYS) == [place]
    assert trusted(authority) == every
    assert (authority.folder / "gpu/operator.pem").read_text() != before


def test_hosts_and_names_mean_those_they_name(authority: Authority) -> None:
    assert authority.places(["gpu"]) == [("gpu", "runner"), ("gpu", "operator")]
    assert authority.places(["operator"]) == [("robot", "operator"), ("gpu", "operator")]
    assert authority.places(["gpu/operator"]) == [("gpu", "operator")]
    with pytest.raises(ConfigError, match=r"expected a host or name, got gpo \(valid: robot, gpu"):
        authority.places(["gpo"])


def test_a_copy_has_no_keys_that_sign(authority: Authority, deployment: Deployment) -> None:
    shutil.rmtree(authority.folder.parent / "signing")
    with pytest.raises(ConfigError, match="were copied here, the keys that signed them were not"):
        Authority(deployment)


@pytest.mark.parametrize("path", ["signing", "signing/gpu.runner.pem"])
def test_keys_that_sign_and_others_could_read_sign_no_more(
    authority: Authority, deployment: Deployment, path: str
) -> None:
    leaked = authority.folder.parent / path
    leaked.chmod(leaked.stat().st_mode | 0o040)
    with pytest.raises(ConfigError, match=r"others may have copied the keys that sign: delete the"):
        Authority(deployment)


def test_deploy_check_warns_of_a_host_whose_tools_have_no_certificate(
    authority: Authority, deployment: Deployment, file: Path
) -> None:
    assert report_this(file, deployment, "gpu").warnings == []
    authority.revoke([("gpu", "operator")])
    (warning,) = report_this(file, deployment, "gpu").warnings
    assert warning.startswith("gpu: no tool reaches the robot from here: operator: no certificate")


def renewed(authority: Authority, made: datetime) -> None:
    authority.renew([("robot", "hal")], made, DAYS)


MISTAKES: dict[str, tuple[Callable[[Authority, Path], Any], str]] = {
    "none": (lambda a, hal: hal.unlink(), "no certificate .*hal.pem; once, .*fairlead certs new"),
    "readable": (lambda a, hal: hal.chmod(0o640), "expected mode 600 .* got 640 .*certs revoke"),
    "ended": (lambda a, hal: renewed(a, LONG_AGO), "ended .* UTC; .*: fairlead certs renew"),
    "early": (lambda a, hal: renewed(a, NOW + timedelta(days=9)), "begins .* set this machine's"),
    "another's": (
        lambda a, hal: shutil.copy(hal.with_stem("safety"), hal),
        "is that of fl/certified/safety, not of fl/certified/hal; copy",
    ),
    "no PEM": (lambda a, hal: hal.write_text("hal"), "cannot be read: .*copy the folder again"),
    "nobody to trust": (
        lambda a, hal: hal.with_name("router.ca").unlink(),
        "router.ca: cannot be read: .*copy the folder again",
    ),
    "half a list": (
        lambda a, hal: hal.with_name("router.ca").write_text("half"),
        "router.ca: cannot be read: .*copy the folder again",
    ),
    "a revoked one": (
        lambda a, hal: kept_though_revoked(a, hal),
        "signed by nobody whom the router lets in; copy the folder .* certs new",
    ),
}


def kept_though_revoked(authority: Authority, hal: Path) -> None:
    kept = hal.read_text()
    authority.revoke([("robot", "hal")])
    authority.new(NOW, DAYS)  # by a signer of the same name
    hal.write_text(kept)


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_service_does_not_start_with(
    mistake: str, authority: Authority, deployment: Deployment
) -> None:
    spoil, text = MISTAKES[mistake]
    assert deployment.endpoints("hal").connect == [deployment.router_endpoint]
    spoil(authority, authority.folder / "robot" / "hal.pem")
    with pytest.raises(ConfigError, match=text):
        deployment.endpoints("hal")


def test_a_router_whose_address_has_changed_does_not_start(
    authority: Authority, deployment: Deployment
) -> None:
    moved = deployment.model_copy(update={"hosts": {"robot": "10.0.0.1", "gpu": "10.0.0.2"}})
    with pytest.raises(ConfigError, match=r"is for 127\.0\.0\.1, and it listens on 10\.0\.0\.1"):
        _ = router_endpoints([moved])
    Authority(moved).renew([("robot", "router")], NOW, DAYS)
    [listen] = router_endpoints([moved]).listen
    assert listen.partition("#")[0] == moved.router_endpoint


def test_a_router_that_would_let_nobody_in_does_not_start(
    authority: Authority, deployment: Deployment
) -> None:
    authority.revoke([place for place in deployment.certified if place[1] != "router"])
    with pytest.raises(ConfigError, match=r"clients\.ca: cannot be read: .*copy the folder again"):
        _ = router_endpoints([deployment])


def test_what_ends_soon_is_warned_of(authority: Authority, deployment: Deployment) -> None:
    assert access_warnings(deployment) == []
    authority.renew([("gpu", "runner")], NOW, 20)
    [warning] = access_warnings(deployment)
    assert warning == (
        "certificate of gpu/runner ends in 19 days; where it was made: fairlead certs renew"
    )
    opened = deployment.model_copy(update={"access": "open"})
    assert access_warnings(opened) == [opened.open_access]


def test_one_that_cannot_be_read_is_warned_of(authority: Authority, deployment: Deployment) -> None:
    """`up` and `status` look at them beside a robot that runs."""
    authority.new(datetime.now(UTC), 365)
    (authority.folder / "gpu" / "runner.pem").write_text("half copied")
    [warning] = access_warnings(deployment)
    assert "runner.pem: cannot be read" in warning and "copy the folder again" in warning


def test_the_commands_say_what_they_did_and_what_to_copy(file: Path, tmp_path: Path) -> None:
    def certs(*words: str) -> str:
        done = fairlead_here("certs", words[0], str(file), *words[1:], state=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert certs("show").count("none here") == len(ROBOT) + len(GPU)
    made = certs("new")
    assert "made robot/router, robot/hal, " in made
    folder = tmp_path / "access" / "certified" / "certificates" / "gpu"
    assert f"  rsync -a --mkpath {folder}/ 127.0.0.2:{folder}/\n" in made
    shown = certs("show")
    assert shown.count(" valid") == len(ROBOT) + len(GPU)
    assert re.search(r"mark [0-9a-f]{12}: the same on every host\n", shown)
    assert certs("renew", "gpu/runner", "--days", "10").startswith("renewed gpu/runner\n")
    assert "ends in 9 days; where it was made: fairlead certs renew" in certs("show")
    states = {one["name"]: one["state"] for one in json.loads(certs("show", "--json"))}
    assert states["hal"] == "valid"
    revoked = certs("revoke", "gpu")
    assert revoked.startswith("revoked gpu/runner, gpu/operator\n")
    assert "fairlead restart router; until then they get in" in revoked
    assert certs("new").startswith("made gpu/runner, gpu/operator\n")


def test_without_certificates_up_refuses_and_names_what_makes_them(
    file: Path, tmp_path: Path
) -> None:
    done = fairlead_here("up", str(file), "--host", "gpu", state=tmp_path)
    assert done.returncode == 1
    [line] = done.stderr.splitlines()
    assert line.startswith("ERROR runner: no certificate ")
    assert "fairlead certs new FILE" in line and "`access: open`" in line


def test_a_deployment_on_one_host_has_no_certificates(tmp_path: Path) -> None:
    done = fairlead_here("certs", "new", "panda_mujoco", state=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1)
    assert "has no certificates: its services are on one host, or access is open" in done.stderr


def test_a_link_ends_with_its_certificate_comes_back_renewed_and_not_once_revoked(
    authority: Authority, deployment: Deployment
) -> None:
    with ExitStack() as stack:

        def opened(endpoints: Endpoints) -> ZenohBus:
            return stack.enter_context(closing(ZenohBus(endpoints)))

        router, tool = opened(router_endpoints([deployment])), opened(deployment.tool_endpoints())
        renewed(authority, datetime.now(UTC) + SOON - timedelta(days=DAYS))
        hal = opened(deployment.endpoints("hal"))
        wait_for(lambda: not hal.has_router, "the certificate has ended")
        assert tool.has_router
        renewed(authority, NOW)
        wait_for(lambda: hal.has_router, "the HAL takes the renewed one")

        kept = (authority.folder / "robot/hal.pem").read_text()
        authority.revoke([("robot", "hal")])
        (authority.folder / "robot/hal.pem").write_text(kept)
        router.close()
        wait_for(lambda: not (hal.has_router or tool.has_router), "both have lost the router")
        opened(router_endpoints([deployment]))
        wait_for(lambda: tool.has_router, "the tool is back")
        assert not hal.has_router, "it tries as often, and its certificate is revoked"


def test_a_router_at_another_address_or_with_a_clients_certificate_is_not_believed(
    authority: Authority, deployment: Deployment
) -> None:
    elsewhere = deployment.model_copy(update={"hosts": {"robot": "127.0.0.3", "gpu": "127.0.0.2"}})
    mine = deployment.endpoints("hal")
    for wrong in ("router", "operator"):
        Authority(elsewhere).renew([("robot", wrong)], NOW, DAYS)
        certificate = read_certificate(authority.folder / f"robot/{wrong}.pem")
        listen = certified_endpoint(deployment.router_endpoint, certificate)
        router = Endpoints([listen], mode="router")
        refused = pytest.raises(TransportError, match="do the certificates fit")
        with closing(ZenohBus(router)), refused:
            ZenohBus(mine)
