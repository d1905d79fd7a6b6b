"""A checkpoint and a skill that names it; an interpreter whose lerobot and torch are stand-ins.

They have what `lerobot_side` touches, on numpy; the real ones: ``LEROBOT=PYTHON make peers``.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from fairlead.errors import ConfigError, PolicyError
from fairlead.policy import Observation
from fairlead.skill.manifest import SkillManifest, load_skill, read_skill
from fairlead_skill_runner.policies.lerobot.policy import LerobotPolicy

NAME, EYE, STATE, DIM, SIDE_PX, ROWS, HORIZON = "lerobot-test", "eye", 8, 7, 64, 12, 8
FILES = ("model.safetensors", "policy_preprocessor.json", "policy_postprocessor.json")

TORCH = """
import numpy as np
float32 = np.float32
class Tensor(np.ndarray):
    def movedim(self, one, other): return np.moveaxis(self, one, other)
    def to(self, *what): return self.astype(what[-1])
    def contiguous(self): return np.ascontiguousarray(self).view(Tensor)
    def numpy(self): return np.asarray(self)
def from_numpy(array): return array.view(Tensor)
def manual_seed(seed): manual_seed.given = seed
manual_seed(0)
def set_num_threads(count): set_num_threads.given = count
"""
CONFIG = """
import json
from pathlib import Path
from types import SimpleNamespace as Named
def features(found):
    return {name: Named(type=name, shape=tuple(shape)) for name, shape in found.items()}
class PreTrainedConfig:
    @classmethod
    def from_pretrained(cls, folder):
        config = Named(**json.loads((Path(folder) / "config.json").read_text()))
        config.input_features = features(config.inputs)
        config.output_features = features(config.outputs)
        return config
"""
RTC = """
class RTCConfig:
    execution_horizon = 10
    def __init__(self, execution_horizon):
        self.execution_horizon, self.enabled = execution_horizon, False
"""
FACTORY = """
import os, signal, sys
from types import SimpleNamespace as Named
import numpy as np
import torch
class Policy:
    @classmethod
    def from_pretrained(cls, folder, config, strict):
        assert strict and config.pretrained_backbone_weights is None
        print("noise on the standard output")
        policy = cls()
        policy.config, policy.asked = config, 0
        return policy
    def reset(self): self.asked = 0
    def supports_rtc(self): return self.config.type == "smolvla"
    def init_rtc_processor(self): self.rtc = self.config.rtc_config
    def predict_action_chunk(self, batch, **meanwhile):
        assert batch.get("action") is None
        self.asked += 1
        if self.asked > 1:  # the first is the probe, or a goal's first
            DOES[self.config.does]()
        state, eye = batch["observation.state"], batch["observation.images.eye"]
        if self.config.observation_delta_indices is not None:
            assert eye.shape[:2] == state.shape[:2]
            state, eye = state[:, 0], eye[:, 0]
        assert eye.shape[:2] == (1, 3) and eye.dtype == state.dtype == np.float32
        rows = np.zeros((1, self.config.rows, self.config.outputs["action"][0]), np.float32)
        rows[0, :, 0], rows[0, :, 1], rows[0, :, 2] = state[0, 0], eye[0, 2, 1, 0], self.asked
        rows[0, :, 3], rows[0, :, 4] = len(batch["task"][0]), torch.manual_seed.given
        rows[0, :, 5] = torch.set_num_threads.given
        if self.config.does == "nan" and state[0, 0] > 1:
            rows[0, 2, 5] = self.config.number
        rows *= self.config.scale
        if meanwhile:
            count, before = meanwhile["inference_delay"], meanwhile["prev_chunk_left_over"]
            assert self.rtc.enabled and self.rtc.execution_horizon == len(rows[0])
            assert (before is None) == (count == 0)
            rows[0, :count] = before[:count] if count else 0
        return rows.view(torch.Tensor)
def fail(): raise KeyError("no such token")
def hang():
    signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
    signal.pause()
def die(): os.kill(os.getpid(), signal.SIGKILL)
DOES = {"": lambda: None, "nan": lambda: None, "fail": fail, "hang": hang, "die": die,
        "nonsense": lambda: os.write(int(sys.argv[1]), b"\\0\\0\\0\\2{]")}
class Pipeline:
    def __init__(self, steps, scale): self.steps, self.scale = steps, scale
    def __call__(self, data):
        if not isinstance(data, dict): return data / self.scale
        action = data.get("action")
        return data | {"action": None if action is None else action * self.scale}
    def reset(self): pass
def get_policy_class(name): return Policy
def make_pre_post_processors(config, pretrained_path, preprocessor_overrides):
    steps = [Named(norm_map={}, features={}, stats=None)]
    steps.append(Named(norm_map=config.norm, features=dict(config.inputs), stats=config.stats))
    return Pipeline(steps, config.scale), Pipeline([], config.scale)
"""


def other_python(folder: Path, version: str = "0.6.1") -> Path:
    """A program that runs a file as an interpreter with lerobot would."""
    packages = folder / "site"
    for name, text in {
        "torch.py": TORCH, "lerobot/configs/policies.py": CONFIG,
        "lerobot/policies/factory.py": FACTORY,
        "lerobot/policies/rtc/configuration_rtc.py": RTC,
        f"lerobot-{version}.dist-info/METADATA": f"Name: lerobot\nVersion: {version}\n",
    }.items():  # fmt: skip
        (packages / name).parent.mkdir(parents=True, exist_ok=True)
        (packages / name).write_text(text)
    program = folder / "python"
    program.write_text(
        f"#!{sys.executable}\nimport runpy, sys\nsys.path[:0] = ['', {str(packages)!r}]\n"
        "assert sys.argv[1] == '-E'\nsys.argv = sys.argv[2:]\n"
        "runpy.run_path(sys.argv[0], run_name='__main__')\n"
    )
    program.chmod(0o755)
    return program


def checkpoint(folder: Path, **changes: Any) -> Path:
    """One that fits the skill, but for the changes."""
    folder.mkdir(parents=True, exist_ok=True)
    document: dict[str, Any] = {
        "type": "act", "device": "cpu", "pretrained_backbone_weights": "to be downloaded",
        "inputs": {
            "observation.state": [STATE], f"observation.images.{EYE}": [3, SIDE_PX, SIDE_PX],
        },
        "outputs": {"action": [DIM]}, "observation_delta_indices": None, "rows": ROWS, "does": "",
        "chunk_size": ROWS, "scale": 1,
        "norm": {"observation.state": "MEAN_STD"}, "stats": {"observation.state": {"mean": [0]}},
    }  # fmt: skip
    (folder / "config.json").write_text(json.dumps(document | changes))
    for name in FILES:
        (folder / name).write_text('{"steps": [{"registry_name": "known"}]}')
    return folder


def install(
    skills: Path,
    python: Path,
    deltas: tuple[int, ...] = (0,),
    name: str = NAME,
    clip: float | None = 0.28,
    **options: Any,
) -> SkillManifest:
    """Write a skill below ``skills`` (FAIRLEAD_SKILLS); its checkpoint is in its folder."""
    document = load_skill("bc-reach-cube").model_dump(mode="json", exclude_defaults=True)
    for key in ("axes", "dtype"):  # LeRobot turns pictures itself
        del document["images"][EYE][key]
    document |= {
        "id": name, "model_family": "test", "horizon": HORIZON, "execute_steps": HORIZON,
        "policy": {
            "backend": "lerobot", "options": {"python": str(python), "checkpoint": "own"} | options,
        },
    }  # fmt: skip
    if deltas != (0,):
        document["state_contract"]["deltas"] = document["images"][EYE]["deltas"] = list(deltas)
    document["action_contract"]["slots"][0]["clip"] = clip and [-clip, clip]
    (skills / name).mkdir(parents=True, exist_ok=True)
    (skills / name / "rskill.yaml").write_text(yaml.safe_dump(document))
    return read_skill(skills / name)


def seen(deltas: int = 1) -> Observation:
    """The first state begins with 0.25, the last pixel looked at is 51 in the first frame."""
    frames = np.zeros((deltas, SIDE_PX, SIDE_PX, 3), np.uint8)
    frames[0, 1, 0, 2] = 51
    states = np.full((deltas, STATE), 0.5)
    states[0, 0] = 0.25
    several = {EYE: frames} if deltas > 1 else {}
    return Observation(3, states[-1], "go", {EYE: frames[-1]}, frames=several, earlier=states[:-1])


@contextmanager
def made(skill: SkillManifest) -> Iterator[LerobotPolicy]:
    with closing(LerobotPolicy.from_options(skill, skill.policy.options)) as policy:
        yield policy


def refusal(skill: SkillManifest) -> str:
    with pytest.raises((ConfigError, PolicyError)) as caught, made(skill):
        pass
    return str(caught.value)
