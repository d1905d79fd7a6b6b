"""What a skill's policy would see, pictures included, in a tool that drives the simulator itself.

Pictures come from the HAL's own camera process, and the runner's own buffer makes the observation:
a deployed policy sees the same bits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fairlead.errors import ConfigError
from fairlead.messages import FloatArray, HalCamera, LayoutState, pack_floats
from fairlead.policy import Observation
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.camera_check import camera_problems
from fairlead.skill.manifest import SkillManifest

if TYPE_CHECKING:
    from fairlead_hal_sim import CameraProcess, RobosuiteBackend, SimulatorOptions
    from fairlead_skill_runner import ObservationBuffer

FRAME_WAIT_S = 60.0


class LocalEyes:
    """One skill's observations, episode by episode.

    Raises:
        ConfigError: the skill has pictures, and the simulator has no such camera, or none renders.
    """

    def __init__(
        self, options: SimulatorOptions, robot: RobotManifest, skill: SkillManifest
    ) -> None:
        self._skill = skill
        wanted = {spec.camera for spec in skill.images.values()}
        cameras = tuple(camera for camera in options.cameras if camera.name in wanted)
        names = HalCamera.__struct_fields__
        given = [HalCamera(**{name: getattr(one, name) for name in names}) for one in cameras]
        problems = camera_problems(skill, given, robot.tick_period_ns)
        if problems:
            raise ConfigError(f"skill {skill.id}: " + "; ".join(problems))
        self._periods = {camera.name: camera.period_ticks for camera in cameras}
        self._feed: CameraProcess | None = None
        self._first_tick = 0
        self._buffer: ObservationBuffer | None = None
        if cameras:
            from fairlead_hal_sim import start_camera_process

            seen = options.model_copy(update={"cameras": cameras})
            self._feed = start_camera_process(seen, 1e9 / robot.tick_period_ns)
            if self._feed is None:
                raise ConfigError(f"skill {skill.id}: no camera renders; see the log above")

    def begin(self, first_tick: int) -> None:
        """A new episode: nothing has been seen."""
        from fairlead_skill_runner import ObservationBuffer

        self._first_tick = first_tick
        self._buffer = ObservationBuffer(
            self._skill, self._skill.prompt, self._periods, exact=True, has_task=False
        )

    def look(self, tick: int, backend: RobosuiteBackend) -> None:
        """Take the frames that are due in a tick; call it in each, before the simulator's step.

        Raises:
            ConfigError: the camera process ended.
        """
        since = tick - self._first_tick
        due = [name for name, period in self._periods.items() if since % period == 0]
        if not due:
            return
        assert self._feed is not None and self._buffer is not None
        self._feed.request(0, tick, due, backend.snapshot())
        for _ in due:
            image = self._feed.take(FRAME_WAIT_S)
            if image is None:
                raise ConfigError(f"skill {self._skill.id}: no frame: {self._feed.failure}")
            self._buffer.add_image(image)

    def observation(self, tick: int, state: FloatArray) -> Observation:
        """Of the tick that was looked at last, with its state vector, float64 ``[dim]``.

        Raises:
            ConfigError: what a deployed policy would wait for: no frame that counts.
        """
        self.feel(tick, state)
        assert self._buffer is not None
        missing = self._buffer.missing(tick)
        if missing:
            raise ConfigError(f"skill {self._skill.id}: tick {tick}: nothing to go by: {missing}")
        return self._buffer.gather().observation

    def feel(self, tick: int, state: FloatArray) -> None:
        """Keep a state vector; a skill that wants earlier ones needs that of each tick."""
        assert self._buffer is not None, "begin() comes first"
        self._buffer.add_layout(
            LayoutState(
                session=0, tick=tick, episode_tick=self._first_tick, oldest_tick=tick,
                skill=self._skill.id, skill_hash=self._skill.skill_hash,
                layout=self._skill.state_contract.layout_name, values=pack_floats(state),
                fault=None,
            )
        )  # fmt: skip

    def close(self) -> None:
        """End the camera process."""
        if self._feed is not None:
            self._feed.close()
