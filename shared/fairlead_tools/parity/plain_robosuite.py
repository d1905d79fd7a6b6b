"""A loop of ``env.step`` as a training script writes it, in a process of its own.

Run by its path. It imports robosuite and the modules that register environments (the scene), and
nothing else of fairlead. One job comes on stdin as JSON: what to make, the seed, how many zero
vectors first, and the vectors of each episode as float32 in hex. On stdout, per episode: the state
before each step as float64 in hex, and at the end the modules of fairlead that were imported.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import sys
from typing import Any

import numpy as np


def make(job: dict[str, Any]) -> Any:
    """The environment, seeded, with everything in it that a training run would set."""
    for module in job["imports"]:
        importlib.import_module(module)
    import robosuite

    config = robosuite.load_composite_controller_config(
        controller=job["controller"], robot=job["robot"]
    )
    if job["part_order"] is not None:
        specific = config.setdefault("composite_controller_specific_configs", {})
        specific["body_part_ordering"] = job["part_order"]
    return robosuite.make(
        job["env"],
        robots=job["robot"],
        controller_configs=config,
        seed=0,
        control_freq=job["control_hz"],
        has_renderer=False,
        has_offscreen_renderer=False,
        use_camera_obs=False,
        ignore_done=True,
        hard_reset=False,
        initialization_noise=None,
        **job["env_options"],
    )


def run(env: Any, episode: dict[str, Any]) -> dict[str, list[str]]:
    """Reset, step the zero vectors, step the policy's; the state before each."""
    env.rng.bit_generator.state = np.random.default_rng(episode["seed"]).bit_generator.state
    env.reset()
    zero = env.robots[0].composite_controller.create_action_vector({})
    vectors = [zero.astype(np.float32)] * episode["zeros"]
    vectors += [np.frombuffer(bytes.fromhex(one), dtype="<f4") for one in episode["vectors"]]
    qpos: list[str] = []
    qvel: list[str] = []
    for vector in vectors:
        note(env, qpos, qvel)
        env.step(vector.copy())  # robosuite turns the base's numbers in place
    stepped = [vector.astype("<f4").tobytes().hex() for vector in vectors]
    return {"packed": stepped, "qpos": qpos, "qvel": qvel}


def note(env: Any, qpos: list[str], qvel: list[str]) -> None:
    """Keep the state as it is."""
    qpos.append(np.array(env.sim.data.qpos, dtype="<f8").tobytes().hex())
    qvel.append(np.array(env.sim.data.qvel, dtype="<f8").tobytes().hex())


def main() -> None:
    """Read the job, run its episodes, write what they computed."""
    job = json.load(sys.stdin)
    with contextlib.redirect_stdout(sys.stderr):  # robosuite prints
        env = make(job)
        episodes = [run(env, one) for one in job["episodes"]]
    ours = sorted(name for name in sys.modules if name.split(".")[0].startswith("fairlead"))
    json.dump({"episodes": episodes, "imported": ours}, sys.stdout)


if __name__ == "__main__":
    main()
