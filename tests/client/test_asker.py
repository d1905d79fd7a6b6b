"""By what name services log who asked."""

from __future__ import annotations

import getpass
import os
import socket
from pathlib import Path

import pytest

from fairlead.deploy.certificates import certificates_dir
from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ConfigError
from fairlead.operate.asker import OPERATOR_VARIABLE, asker
from fairlead.paths import ACCESS_VARIABLE, repo_root

ONE_HOST = load_deployment(repo_root() / "compose" / "panda_mobile_sim.yaml")
TWO_HOSTS = load_deployment(repo_root() / "compose" / "panda_mobile_two_hosts.yaml")
HERE = socket.gethostname()


@pytest.fixture(autouse=True)
def nobody_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(OPERATOR_VARIABLE, raising=False)


def test_it_is_the_user_unless_a_person_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    assert asker(ONE_HOST, "fairlead run") == f"{getpass.getuser()}@{HERE} (fairlead run)"
    monkeypatch.setenv(OPERATOR_VARIABLE, "ada")
    assert asker(ONE_HOST, "fairlead run") == f"ada@{HERE} (fairlead run)"


@pytest.mark.parametrize("name", ["", "Ada Lovelace", "ada@lab"])
def test_a_name_that_would_read_as_another_is_refused(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setenv(OPERATOR_VARIABLE, name)
    with pytest.raises(ConfigError, match=f"^{OPERATOR_VARIABLE}: expected 1 to 64 of a-z 0-9"):
        asker(ONE_HOST, "a program")


def test_a_user_without_a_name_has_a_number(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> str:
        raise KeyError("no such user")

    monkeypatch.setattr(getpass, "getuser", fail)
    assert asker(ONE_HOST, "a program") == f"user-{os.getuid()}@{HERE} (a program)"


def test_the_host_is_that_of_the_certificate_or_the_machines_own_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(ACCESS_VARIABLE, str(tmp_path))
    monkeypatch.setenv(OPERATOR_VARIABLE, "ada")
    assert asker(TWO_HOSTS, "a program") == f"ada@{HERE} (a program)"
    folder = certificates_dir(TWO_HOSTS.keys) / "gpu"
    folder.mkdir(parents=True)
    (folder / "operator.pem").touch()
    assert asker(TWO_HOSTS, "a program") == "ada@gpu (a program)"
