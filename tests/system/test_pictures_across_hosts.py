"""A policy on another host sees the robot's camera: JPEG over the link, near what was rendered."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from bench.equipment.rendering import CAN_RENDER
from fairlead.deploy.deployment import load_deployment
from fairlead.paths import deployment_path, rskill_dir
from fairlead.skill.manifest import load_skill
from fairlead_tools.learn.record import record
from tests.system.two_hosts import two_hosts
from tests.system.two_networks import two_networks

pytestmark = [
    pytest.mark.processes,
    pytest.mark.simulator,
    pytest.mark.timeout(300),
    pytest.mark.skipif(not CAN_RENDER, reason="no rendering library on this machine"),
]

SKILL, SEED, SIZE_PX = "watches", 3, 128
CAMERA = {
    "name": "robot0_agentview_left", "width": SIZE_PX, "height": SIZE_PX, "period_ticks": 1,
}  # fmt: skip
POLICY = """
from pathlib import Path

import numpy as np
from fairlead.policy import Done


class Policy:
    @classmethod
    def from_options(cls, skill, options):
        policy = cls()
        policy.folder = Path(options["folder"])
        return policy

    def reset(self):
        self.seen = []

    def infer(self, observation):
        if len(self.seen) == 2:
            np.save(self.folder / "seen.npy", self.seen)
            return Done("it has seen enough")
        self.seen.append(observation.images["eye"])
        rows = np.zeros((8, 12), np.float32)
        rows[:, 2] = 0.2
        return rows
"""
Pictures = np.ndarray[Any, np.dtype[np.uint8]]


def write_skill(skills: Path, seen: Path) -> None:
    manifest = yaml.safe_load(
        (rskill_dir("oracle-counter-to-cabinet") / "rskill.yaml").read_text(encoding="utf-8")
    )
    own = {"file": "policy.py", "class": "Policy", "options": {"folder": str(seen)}}
    eye = {"camera": CAMERA["name"], "width": SIZE_PX, "height": SIZE_PX}
    manifest |= {
        "id": SKILL, "decided_by": "policy", "images": {"eye": eye},
        "policy": {"backend": "python", "options": own},
    }  # fmt: skip
    (skills / SKILL).mkdir(parents=True)
    (skills / SKILL / "rskill.yaml").write_text(yaml.safe_dump(manifest), encoding="utf-8")
    (skills / SKILL / "policy.py").write_text(POLICY, encoding="utf-8")


def rendered(folder: Path) -> Pictures:
    """What the HAL's own cameras show before the first row and after eight, as it is."""
    deployment = yaml.safe_load(deployment_path("panda_mobile_sim").read_text(encoding="utf-8"))
    deployment["services"]["hal"]["options"]["cameras"] = [CAMERA]
    file = folder / "plain.yaml"
    file.write_text(yaml.safe_dump(deployment), encoding="utf-8")
    [local] = record(
        load_deployment(file), load_skill(SKILL), [SEED], 0.0, 20, lambda seed, tick: None
    )
    return local.pictures["eye"][[0, 8]]


def apart(one: Pictures, other: Pictures) -> float:
    """Mean distance of their numbers [levels of 255]."""
    return float(np.abs(one.astype(float) - other.astype(float)).mean())


@pytest.mark.thorough
def test_jpeg_from_the_robot_s_camera_is_near_what_was_rendered_and_of_its_tick(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path / "skills"))
    write_skill(tmp_path / "skills", tmp_path)
    sent = [CAMERA | {"jpeg_quality": 90}]
    with two_networks() as network:
        if network.why_loopback:
            pytest.skip(f"all is one host: {network.why_loopback}")
        with two_hosts(network, tmp_path / "two", "lockstep", cameras=sent) as hosts:
            result = hosts.ask("gpu", "run", SKILL, "--seed", str(SEED))["result"]
            log = hosts.state_of("gpu", "logs") / "runner.log"
            said = log.read_text(encoding="utf-8")
    assert result["outcome"] == "succeeded", result
    assert "frames come through shared memory" not in said
    seen, wanted = np.load(tmp_path / "seen.npy"), rendered(tmp_path)
    assert seen.shape == (2, SIZE_PX, SIZE_PX, 3)
    distances = [[apart(one, own) for own in wanted] for one in seen]
    for index, own in enumerate(distances):
        assert 0.0 < own[index] < 2.0, "lossy, and near"
        assert own[index] < own[1 - index], "the other tick's is farther"
