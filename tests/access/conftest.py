"""A deployment on two hosts with its certificates, in folders of the test's own."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.paths import ACCESS_VARIABLE
from fairlead_tools.certificates.authority import Authority
from fairlead_tools.supervisor.this_host import free_ports
from tests.access.certified import DAYS, NOW, SOURCE


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(ACCESS_VARIABLE, str(tmp_path / "access"))
    content = yaml.safe_load(SOURCE.read_text(encoding="utf-8"))
    content |= {"hosts": {"robot": "127.0.0.1", "gpu": "127.0.0.2"}, "id": "certified"}
    content["router"]["port"] = free_ports(1)[0]
    path = tmp_path / "deployment.yaml"
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return path


@pytest.fixture
def deployment(file: Path) -> Deployment:
    return load_deployment(file)


@pytest.fixture
def authority(deployment: Deployment) -> Authority:
    authority = Authority(deployment)
    authority.new(NOW, DAYS)
    return authority
