"""An SO-101 whose servos are emulated: the HAL of the real arm, on a bus that can fail."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path

import yaml

from bench.equipment.emulated_arm import EmulatedArm, emulated_arm
from bench.equipment.live_robot import wait_for
from bench.equipment.motion_log import hold_delay_ms
from bench.faults.live_stage import Changes, LiveStage
from bench.faults.motion_rules import every_row_was_judged_for_its_tick
from bench.faults.other_load import OtherLoad
from bench.faults.row import Shot
from bench.so101_bus import ROBOT, calibration
from fairlead.deploy.registry import Registry
from fairlead.deploy.scheduling import realtime_words
from fairlead.errors import ConfigError
from fairlead.messages import GateState, JointState, decode, floats
from fairlead.paths import SKILLS_VARIABLE, repo_root, rskill_dir
from fairlead.wire.bus import Sample
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)

SOURCE = repo_root() / "compose" / "so101_mujoco.yaml"
PAN, SWING_RAD, STEP_RAD = 0, 1.4, 0.005
"""The arm swings from side to side, a way of 5 s at least."""
SIDES = {"swing-left": SWING_RAD, "swing-right": -SWING_RAD}
EMULATOR_PRIORITY = 50
NEAR_RAD = 0.05
assert ROBOT.home is not None
HOME_RAD = tuple(ROBOT.home.positions[name] for name in ROBOT.joint_names)


class ServoStage(LiveStage):
    """An arm that swings for as long as its goal lasts, and what its HAL measured.

    measured: CLOCK_MONOTONIC of each tick's measurement [ns], and where the first joint was [rad].
    """

    def __init__(self, robot: ScratchRobot, plugged: ExitStack, arm: EmulatedArm) -> None:
        super().__init__(robot)
        self.measured: list[tuple[int, float]] = []
        self.arm, self._plugged = arm, plugged
        self.client.bus.subscribe(self.client.keys.joints, self._on_joints)

    def _on_joints(self, sample: Sample) -> None:
        state = decode(JointState, sample.payload)
        self.measured.append((state.stamp_ns, float(floats(state.positions)[PAN])))

    # --- the bus ---------------------------------------------------------------------

    def plug_in(self) -> None:
        """An adapter again, and a new HAL: an arm in its home pose, that somebody held."""
        self.arm = self._plugged.enter_context(_emulated(self.arm.port.parent))
        self.restart()

    def unplug(self) -> int:
        """The adapter; CLOCK_MONOTONIC just before [ns]."""
        now_ns = time.monotonic_ns()
        self._plugged.close()
        return now_ns

    def order(self, line: str) -> int:
        """A fault of the bus or a servo; CLOCK_MONOTONIC just before [ns]."""
        now_ns = time.monotonic_ns()
        assert self.arm.order(line) == f"done: {line}"
        return now_ns

    def repair(self) -> None:
        """All servos as after they were switched on, at home in somebody's hands; a new HAL."""
        for line in ("plug", "noise 0", "dip"):
            self.order(line)
        hands = list(enumerate(HOME_RAD, start=1))
        for servo_id, position in hands:
            self.order(f"pull {servo_id} {position}")
        for servo_id, position in hands:
            wait_for(
                lambda: abs(float(self.arm.order(f"where {servo_id}")) - position) < NEAR_RAD,  # noqa: B023
                f"servo {servo_id} is at home",
            )
        self.restart()
        for servo_id, _ in hands:
            self.order(f"pull {servo_id}")

    def restart(self) -> None:
        """A new HAL, with the port and the servos that are there now."""
        self.signal("hal", signal.SIGKILL)
        self.restarted("hal")

    # --- goals -----------------------------------------------------------------------

    def make_ready(self, seed: int) -> None:
        """Armed, and towards the side that is farther; a real arm has no episodes."""
        if self.client.hal_status().state == "fault":
            self.repair()
        self.recover()
        if self.client.gate_status().state == GateState.ARMED:
            self.client.disarm()
        self.client.arm()
        self._others = OtherLoad()
        self._skill = max(SIDES, key=lambda name: abs(SIDES[name] - self.measured[-1][1]))

    # --- measurements ----------------------------------------------------------------

    def fault_shot(self, injected_ns: int, *texts: str) -> Shot:
        """Injection to the hold, where the HAL has a fault that says this; also: to the stop."""
        wait_for(lambda: self.client.hal_status().state == "fault", "the HAL says a fault")
        detail = self.client.hal_status().detail
        missing = [text for text in texts if text not in detail]
        assert not missing, f"{detail!r} does not say {missing}"
        wait_for(lambda: not self.motion.read()[-1].moves, "the HAL's log says so")
        stop_ms = self.stop_ms(injected_ns)
        delay_ms = hold_delay_ms(self.motion.since(injected_ns), injected_ns)
        every_row_was_judged_for_its_tick(self)
        ended_ns = injected_ns + int(delay_ms * 1e6)
        return Shot(delay_ms, injected_ns, ended_ns, self.tick_ms(injected_ns), detail, stop_ms)


def _emulated(folder: Path) -> AbstractContextManager[EmulatedArm]:
    """A real bus does not wait for a processor: nor does this one, where the system permits it."""
    try:
        before = realtime_words("emulator", EMULATOR_PRIORITY)
    except ConfigError:
        before = []
    return emulated_arm(folder, before=before)


def _swinging_skills(folder: Path) -> Path:
    """A folder of skills that bring the arm to one side, slowly."""
    for name, pan in SIDES.items():
        skill = yaml.safe_load((rskill_dir("so101-reach") / "rskill.yaml").read_text())
        skill["id"] = name
        skill["policy"]["options"] |= {"target_rad": [pan, *HOME_RAD[1:]], "step_rad": STEP_RAD}
        (folder / name).mkdir(parents=True)
        (folder / name / "rskill.yaml").write_text(yaml.safe_dump(skill), encoding="utf-8")
    return folder


@contextmanager
def servo_stage(folder: Path) -> Iterator[ServoStage]:
    """All services, started, and the arm's servos."""
    file, port = folder / "arm.yaml", folder / "arm" / "so101"
    calibration(file)
    hal = {"run": "hal_so101", "options": {"port": str(port), "calibration": str(file)}}
    scratch = make_scratch(SOURCE, folder / "state", ScratchOptions(hal=hal))
    skills = {SKILLS_VARIABLE: str(_swinging_skills(folder / "skills"))}
    changes = Changes(environment={"": skills})
    with ExitStack() as plugged:
        arm = plugged.enter_context(_emulated(port.parent))
        with scratch_robot(scratch, Registry(folder / "registry"), command=changes.words) as robot:
            stage = ServoStage(robot, plugged, arm)
            wait_for(lambda: bool(stage.measured), "a joint state")
            yield stage
