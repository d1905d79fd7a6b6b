"""Folders of what proves names, and those above them, are this user's alone whatever the umask."""

from __future__ import annotations

import os
import subprocess
from datetime import UTC, datetime
from pathlib import Path

import pytest

from fairlead.deploy.credentials import find_secrets
from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.process_table import process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry
from fairlead.errors import ConfigError
from fairlead.paths import ACCESS_VARIABLE, repo_root
from fairlead_tools.certificates.authority import Authority
from tests.access.intruder import NOBODY
from tests.cli.command import fairlead_command, fairlead_here

ONE_HOST, TWO_HOSTS = "panda_mobile_sim.yaml", "panda_mobile_two_hosts.yaml"


@pytest.mark.processes
@pytest.mark.parametrize(
    ("command", "file"), [(("certs", "new"), TWO_HOSTS), (("status", "-d"), ONE_HOST)]
)
def test_nobody_else_may_write_beside_them(
    command: tuple[str, str], file: str, tmp_path: Path
) -> None:
    kept = {name: value for name, value in os.environ.items() if name.startswith(("PATH", "LANG"))}
    subprocess.run(
        fairlead_command(*command, str(repo_root() / "compose" / file)),
        env=kept | {"HOME": str(tmp_path)}, umask=0, capture_output=True, check=False,
    )  # fmt: skip
    made = [path for path in tmp_path.rglob("*") if path.is_dir()]
    assert tmp_path / ".local/state/fairlead/access" in made
    assert {path: oct(path.stat().st_mode & 0o777) for path in made} == dict.fromkeys(made, "0o700")


@pytest.mark.parametrize("user", [os.getuid(), NOBODY])
def test_where_others_could_put_another_folder_in_their_place_nothing_is_believed(
    user: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(ACCESS_VARIABLE, str(tmp_path / "access"))
    one, two = (load_deployment(repo_root() / "compose" / one) for one in (ONE_HOST, TWO_HOSTS))
    find_secrets(one.keys, ["operator"])
    Authority(two).new(datetime.now(UTC), 1)
    if user == os.getuid():
        (tmp_path / "access").chmod(0o777)
    elif os.getuid():
        pytest.skip("only root can give folders away")
    else:
        os.chown(tmp_path / "access", user, -1)
    who, mend = f"uid {user}", f"run this as uid {user}"
    if user == os.getuid():
        who, mend = "others", "chmod go-w"
    said = f"^access: {tmp_path / 'access'}: {who} can write there; {mend}, or FAIRLEAD_ACCESS"
    with pytest.raises(ConfigError, match=said):
        find_secrets(one.keys, ["operator"])
    for asked in (lambda: two.endpoints("hal"), lambda: Authority(two)):
        with pytest.raises(ConfigError, match=said):
            asked()


def test_a_stop_that_they_keep_from_being_sent_says_what_ends_its_services(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(ACCESS_VARIABLE, str(tmp_path / "access"))
    file = repo_root() / "compose" / ONE_HOST
    own = ServiceEntry(process_id(os.getpid()), ready=True, restarts=0)
    registry = Registry(tmp_path)
    registry.write(Running("panda_mobile", str(file), "/state", None, {"safety": own}))
    passwords = find_secrets(load_deployment(file).keys, ["operator"]).file
    passwords.chmod(0o644)
    done = fairlead_here("stop", state=tmp_path)
    assert done.returncode == 1
    assert f"NOT STOPPED: access: {passwords}: expected mode 600 of this user" in done.stderr
    assert done.stderr.endswith(
        "; if no stop gets through: fairlead down panda_mobile ends its services, and the robot "
        "holds\n"
    )
