"""Gathers what one observation needs, by tick, and knows what is missing or comes no more."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from math import gcd
from typing import Any

import numpy as np
import numpy.typing as npt

from fairlead.jpeg import decoded
from fairlead.messages import Image, LayoutState, TaskState, floats
from fairlead.policy import Observation
from fairlead.skill.image_spec import ImageSpec
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.picture import picture
from fairlead_skill_runner.tick_history import FrameHistory, TickHistory


@dataclass(frozen=True)
class TimedObservation:
    """One complete observation; oldest_tick is the age of its oldest input."""

    observation: Observation
    oldest_tick: int


class ObservationBuffer:
    """Newest layout, task state and camera frames of one goal.

    Args:
        camera_periods: ticks between frames, by camera name.
        periods: control periods for one row of the policy.
        exact: lockstep: the layout, the task state and the due frames of one tick, and no
            others, so that every run sees the same; otherwise the newest of each.
        has_task: nothing is observed before the task's own state is known.
    """

    def __init__(
        self,
        skill: SkillManifest,
        prompt: str,
        camera_periods: Mapping[str, int],
        *,
        exact: bool,
        has_task: bool,
        periods: int = 1,
    ) -> None:
        self._skill = skill
        self._prompt = prompt
        self._periods = camera_periods
        self._exact = exact
        self._has_task = has_task
        self._state_deltas = [delta * periods for delta in skill.state_contract.deltas]
        self._layouts = TickHistory[LayoutState](-self._state_deltas[0])
        self.task: TaskState | None = None
        self._deltas = {
            name: [delta * periods for delta in spec.deltas] for name, spec in skill.images.items()
        }
        back: dict[str, int] = {}
        contrast: dict[str, float] = {}
        for name, spec in skill.images.items():
            back[spec.camera] = max(back.get(spec.camera, 0), -self._deltas[name][0])
            contrast[spec.camera] = max(contrast.get(spec.camera, 0.0), spec.contrast_min)
        self._cameras = {
            camera: FrameHistory(ticks, contrast[camera]) for camera, ticks in back.items()
        }
        self._made: dict[str, dict[int, npt.NDArray[Any]]] = {name: {} for name in skill.images}

    @property
    def layout(self) -> LayoutState | None:
        """The newest state vector."""
        return self._layouts.newest

    def add_layout(self, layout: LayoutState) -> None:
        """Keep a state vector; a fault is none."""
        if layout.values is not None:
            self._layouts.keep(layout)

    def add_task(self, task: TaskState) -> None:
        """Keep a task state if it is newer."""
        if self.task is None or task.tick > self.task.tick:
            self.task = task

    def add_image(self, image: Image) -> None:
        """Keep a picture of a camera of the skill's; a JPEG is decoded here, once.

        Raises:
            MessageError: it is none.
        """
        if image.camera in self._cameras:
            self._cameras[image.camera].add(decoded(image))

    def is_ahead_of(self, tick: int) -> bool:
        """Whether the newest layout is of a later tick."""
        return self.layout is not None and self.layout.tick > tick

    def missing(self, tick: int) -> str:
        """What an observation of ``tick`` (or newer, unless exact) still lacks; "" if nothing."""
        if self.layout is None or self.layout.tick < tick:
            return f"layout {self._skill.state_contract.layout_name}"
        lost = self._layouts.missing_tick(self._state_deltas, self.layout.episode_tick)
        if lost is not None:
            return f"layout {self._skill.state_contract.layout_name} of tick {lost}"
        if self._has_task and (self.task is None or (self._exact and self.task.tick < tick)):
            return "task state"
        for name, spec in self._skill.images.items():
            if not self._usable(spec, self.layout):
                trouble = self._cameras[spec.camera].trouble()
                return f"image {name} from camera {spec.camera}" + (trouble and f": {trouble}")
            history = self._cameras[spec.camera]
            lost = history.missing_tick(self._deltas[name], self.layout.episode_tick)
            if lost is not None:
                return (
                    f"image {name} of tick {lost} from camera {spec.camera} (its deltas want one "
                    f"every {gcd(*self._deltas[name])} ticks, the last came {history.spacing()})"
                )
        return ""

    def blind(self, tick: int) -> str:
        """The camera whose newest picture is older than the skill allows, and what it does."""
        limit = self._skill.age_max_ticks
        for camera, history in self._cameras.items():
            if history.newest is not None and tick - history.newest.tick > limit:
                return (
                    f"camera {camera}: newest picture of tick {history.newest.tick}, "
                    f"{tick - history.newest.tick} ticks ago (age_max_ticks {limit}); "
                    f"{history.trouble() or 'nothing has come since'}"
                )
        return ""

    def gather(self) -> TimedObservation:
        """The observation of the newest layout; call it when nothing is missing.

        Raises:
            PolicyError: for a picture that is not what the skill declares.
        """
        layout = self.layout
        assert layout is not None and layout.values is not None
        images, frames, oldest = {}, {}, min(layout.tick, layout.oldest_tick)
        for name, spec in self._skill.images.items():
            kept = self._cameras[spec.camera].at(self._deltas[name], layout.episode_tick)
            # Of each frame once, however many observations it is in.
            before = self._made[name]
            self._made[name] = made = {
                tick: before[tick] if tick in before else picture(name, spec, image)
                for tick, image in {image.tick: image for image in kept}.items()
            }
            images[name] = made[kept[-1].tick]
            if len(kept) > 1:
                frames[name] = np.stack([made[image.tick] for image in kept])
            oldest = min(oldest, kept[-1].tick)  # earlier frames are as old as they should be
        past = self._layouts.at(self._state_deltas, layout.episode_tick)
        *earlier, state = (floats(one.values) for one in past if one.values is not None)
        observation = Observation(
            layout.tick, state, self._prompt, images, frames=frames, earlier=np.array(earlier)
        )
        return TimedObservation(observation, oldest)

    def _usable(self, spec: ImageSpec, layout: LayoutState) -> bool:
        image = self._cameras[spec.camera].newest
        if image is None or not layout.episode_tick <= image.tick <= layout.tick:
            return False
        if not self._exact:
            return layout.tick - image.tick <= self._skill.age_max_ticks
        since_due = (layout.tick - layout.episode_tick) % self._periods[spec.camera]
        return image.tick == layout.tick - since_due


FAULTS_TO_FAIL = 4
"""In a row: in lockstep, where the world waits, and before a goal has seen a good layout."""
FAULTS_IN_MOTION = 2
"""In a row, of two ticks: realtime, where rows that were released before go on acting."""
SILENCE_S = 0.75
"""Realtime: a goal fails so long after its newest layout; rows may never start again by
themselves because an assembler came back."""


class LayoutWatch:
    """Counts faulty layouts in a row and, in realtime, ticks without any.

    In lockstep the world waits for a layout, and the goal ends by its stall timeout.

    Args:
        rate_hz: control periods a second.
    """

    def __init__(self, *, lockstep: bool, rate_hz: float) -> None:
        self._lockstep = lockstep
        self._silence_ticks = math.ceil(SILENCE_S * rate_hz)
        self._faults = self._fault_tick = self._good_tick = 0

    def good(self, tick: int) -> None:
        """A state vector of ``tick`` came."""
        self._faults = 0
        self._good_tick = max(self._good_tick, tick)

    def is_last_fault(self, tick: int) -> bool:
        """Count a faulty layout; in realtime one tick may be told twice, and counts once."""
        if self._lockstep or tick > self._fault_tick:
            self._faults, self._fault_tick = self._faults + 1, tick
        waits = self._lockstep or not self._good_tick
        return self._faults >= (FAULTS_TO_FAIL if waits else FAULTS_IN_MOTION)

    def silent_ticks(self, tick: int) -> int:
        """Ticks since the newest layout if these are too many at ``tick``, else 0."""
        if self._lockstep or not self._good_tick:
            return 0
        silent = tick - self._good_tick
        return silent if silent > self._silence_ticks else 0
