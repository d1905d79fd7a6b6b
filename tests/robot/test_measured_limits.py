"""The measured-state limits against the simulator at full scale on every axis."""

import numpy as np
import pytest

from fairlead.hal.backend import PartCommand
from fairlead.messages import floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot
from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend

TICKS = 300


@pytest.mark.simulator
@pytest.mark.parametrize(
    "keep_ticks",
    [pytest.param(1, marks=pytest.mark.thorough, id="flicker"), pytest.param(25, id="sustained")],
)
def test_full_scale_driving_stays_within_bounds_tolerance_and_jump_limits(keep_ticks: int) -> None:
    robot = load_robot("panda_mobile")
    measured = robot.profile("sim").measured
    backend = RobosuiteBackend(SimulatorOptions(seed=1))
    rng = np.random.default_rng(1)
    parts = backend.describe().parts
    before = backend.read().positions
    worst: dict[str, float] = {}
    for tick in range(TICKS):
        if tick % keep_ticks == 0:
            commands = {}
            for part in parts:
                mode = ControlMode(part.ranges[0].mode)
                lower, upper = floats(part.ranges[0].lower), floats(part.ranges[0].upper)
                row = np.where(rng.random(lower.shape) < 0.5, lower, upper)
                active: tuple[int, ...] = ()
                if mode.is_joint_mode:
                    active = tuple(robot.joint_names.index(name) for name in part.joints)
                    values = np.zeros(robot.n_dof)
                    values[list(active)] = row
                    row = values
                frame = "base_link" if mode is ControlMode.CARTESIAN_DELTA else ""
                commands[part.name] = PartCommand(mode, frame, row, active)
        backend.apply(commands)
        now = backend.read().positions
        for index, joint in enumerate((*robot.joints, *robot.passive_joints)):
            limits = measured[joint.name]
            used = abs(now[index] - before[index]) / limits.jump_per_tick
            worst[f"{joint.name} jump"] = max(worst.get(f"{joint.name} jump", 0.0), used)
            if joint.has_bounds and limits.tolerance is not None:
                beyond = max(joint.lower - now[index], now[index] - joint.upper, 0.0)
                key = f"{joint.name} bounds"
                worst[key] = max(worst.get(key, 0.0), beyond / limits.tolerance)
        before = now
    backend.close()
    assert {name: share for name, share in worst.items() if share > 1.0} == {}
    assert max(worst.values()) > 0.2, "the drive was too gentle to prove anything"
