"""Where copies of deployments are made: never over what somebody else left there."""

from __future__ import annotations

from pathlib import Path

import pytest

from fairlead.errors import ConfigError
from fairlead.paths import deployment_path, repo_root
from fairlead_tools.supervisor import scratch
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch

SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"


def test_a_folder_of_an_earlier_run_is_emptied(tmp_path: Path) -> None:
    first = make_scratch(SOURCE, tmp_path / "state", ScratchOptions())
    (first.state_dir / "latch").write_text("1", encoding="utf-8")
    second = make_scratch(SOURCE, tmp_path / "state", ScratchOptions())
    assert [path.name for path in second.state_dir.iterdir()] == ["deployment.yaml"]


def test_a_folder_with_other_things_is_left_alone(tmp_path: Path) -> None:
    mine = tmp_path / "state" / "thesis.tex"
    mine.parent.mkdir()
    mine.write_text("mine", encoding="utf-8")
    with pytest.raises(ConfigError, match="holds other things; choose another --out"):
        make_scratch(SOURCE, tmp_path / "state", ScratchOptions())
    assert mine.read_text(encoding="utf-8") == "mine"


def test_a_file_where_the_folder_should_be_is_a_clear_error(tmp_path: Path) -> None:
    (tmp_path / "state").write_text("", encoding="utf-8")
    with pytest.raises(ConfigError, match="cannot be made anew: File exists"):
        make_scratch(SOURCE, tmp_path / "state", ScratchOptions())


def test_ports_are_looked_for_only_where_services_listen_on_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []

    def found(count: int) -> list[int]:
        asked.append(count)
        return [1, 2, 3, 4]

    monkeypatch.setattr(scratch, "free_ports", found)
    plain = make_scratch(SOURCE, tmp_path / "plain", ScratchOptions()).deployment
    assert asked == [] and not any(one.listen for one in plain.services.values())
    options = ScratchOptions(access="open", ports=True)
    listening = make_scratch(SOURCE, tmp_path / "ports", options).deployment
    ports = sorted(one.listen for one in listening.services.values())
    assert asked == [4] and ports == [f"tcp/127.0.0.1:{number}" for number in (1, 2, 3, 4)]


def test_a_copy_of_a_real_robot_would_drive_the_real_one(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="a copy of the robot: expected profile sim, got hardw"):
        make_scratch(deployment_path("so101"), tmp_path / "copy", ScratchOptions())
    assert not (tmp_path / "copy").exists()
