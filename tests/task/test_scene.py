"""What a seed draws."""

from __future__ import annotations

import numpy as np

from fairlead_hal_sim.task.scene import sample_scene

ARM_REACH_M = 0.855


def test_a_seed_draws_the_same_scene_every_time_and_another_seed_another() -> None:
    scenes = [sample_scene(np.random.default_rng(seed)) for seed in (3, 3, 4)]
    assert scenes[0] == scenes[1]
    assert scenes[0] != scenes[2]


def test_the_cabinet_is_always_out_of_the_arms_reach_from_the_counter() -> None:
    for seed in range(200):
        scene = sample_scene(np.random.default_rng(seed))
        reach = np.hypot(scene.cabinet.x - scene.can.x, scene.cabinet.y - scene.can.y)
        start = np.hypot(
            scene.cabinet.x - scene.robot_start[0], scene.cabinet.y - scene.robot_start[1]
        )
        assert min(reach, start) > ARM_REACH_M + 0.3


def test_the_can_always_stands_on_the_counter() -> None:
    for seed in range(200):
        scene = sample_scene(np.random.default_rng(seed))
        cos, sin = np.cos(scene.counter.yaw), np.sin(scene.counter.yaw)
        dx, dy = scene.can.x - scene.counter.x, scene.can.y - scene.counter.y
        depth, side = cos * dx + sin * dy, -sin * dx + cos * dy
        assert 0.10 < depth < 0.18
        assert abs(side) <= 0.20 + 1e-9
