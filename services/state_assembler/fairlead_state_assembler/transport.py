"""The assembler on a bus: ticks on the transport's receive thread, wants on the event loop."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable

from fairlead.errors import ConfigError
from fairlead.keys import Keys, check_name, last_chunk
from fairlead.messages import JointState, LayoutState, Lease, TransformBatch, decode
from fairlead.wire.bus import Bus, Publisher, Qos, Sample
from fairlead.wire.on_loop import call_on
from fairlead_state_assembler.core import AssemblerCore, Output
from fairlead_state_assembler.skill_view import SkillView

MOST_SKILLS = 256
"""Skills that one run answers for: each keeps what it is published with."""


class AssemblerTransport:
    """Feeds an `AssemblerCore` from the bus and publishes what it returns.

    Made on an event loop, where `follow_wants` runs.

    Args:
        name: this service's name, the publisher name of its transforms.
    """

    def __init__(self, bus: Bus, keys: Keys, name: str, core: AssemblerCore) -> None:
        self._bus = bus
        self._keys = keys
        self._core = core
        self._log = logging.getLogger(name)
        self._lock = threading.Lock()
        self._own_tf = keys.tf(name)
        self._links = bus.publisher(self._own_tf, TransformBatch, Qos.HOT)
        self._layouts: dict[str, Publisher] = {}
        self._wants: asyncio.Queue[tuple[str, bool]] = asyncio.Queue()
        loop = asyncio.get_running_loop()

        def on_want(key: str, wanted: bool) -> None:
            call_on(loop, lambda: self._wants.put_nowait((last_chunk(key), wanted)))

        self._declared = [
            bus.subscribe(keys.every_tf, self._on_transforms),
            bus.subscribe(keys.joints, self._on_joints),
            bus.subscribe(keys.lease, self._on_lease),
            bus.watch_tokens(keys.every_want_layout, on_want),
        ]

    def close(self) -> None:
        """Stop listening."""
        for declared in self._declared:
            declared.undeclare()

    def _on_transforms(self, sample: Sample) -> None:
        if sample.key == self._own_tf:
            return
        publisher = last_chunk(sample.key)
        batch = decode(TransformBatch, sample.payload)
        self._take(lambda: self._core.on_transforms(batch, publisher))

    def _on_joints(self, sample: Sample) -> None:
        joints = decode(JointState, sample.payload)
        self._take(lambda: self._core.on_joints(joints))

    def _on_lease(self, sample: Sample) -> None:
        lease = decode(Lease, sample.payload)
        with self._lock:
            self._core.on_lease(lease)

    async def follow_wants(self) -> None:
        """Assemble for the skills that are wanted, until cancelled."""
        while True:
            skill, wanted = await self._wants.get()
            if (refusal := self._refusal(skill)) is not None:
                self._log.error("wanted: %s", refusal)
            elif wanted:
                self._want(await asyncio.to_thread(SkillView, skill))  # reads a file
            else:
                with self._lock:
                    self._core.unwant(skill)
                self._log.info("no longer assembling for %s", skill)

    def _refusal(self, skill: str) -> ConfigError | None:
        """Why nothing is said of a skill: whoever has a runner's credentials may want anything."""
        try:
            check_name("skill", skill)
        except ConfigError as error:
            return error
        if skill in self._layouts or len(self._layouts) < MOST_SKILLS:
            return None
        return ConfigError(f"skill {skill}: expected at most {MOST_SKILLS} skills in one run")

    def _want(self, view: SkillView) -> None:
        with self._lock:
            if view.skill not in self._layouts:
                self._layouts[view.skill] = self._bus.publisher(
                    self._keys.layout(view.skill), LayoutState, Qos.HOT
                )
            outputs = self._core.want(view)
        if view.refusal is not None:
            self._log.error("cannot assemble for %s: %s", view.skill, view.refusal)
        else:
            self._log.info("assembling for %s", view.skill)
        self._publish(outputs)

    def _take(self, step: Callable[[], list[Output]]) -> None:
        """Run one step of the core."""
        with self._lock:
            outputs = step()
        self._publish(outputs)

    def _publish(self, outputs: list[Output]) -> None:
        # Outside the lock: a bus may deliver a put to its readers before put returns.
        for output in outputs:
            publisher = self._links if output.skill is None else self._layouts[output.skill]
            publisher.put_bytes(output.payload)
