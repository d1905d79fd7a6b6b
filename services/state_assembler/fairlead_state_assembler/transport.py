"""The assembler on a bus: everything happens in the transport's callback threads."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from fairlead.keys import Keys, last_chunk
from fairlead.messages import JointState, LayoutState, TransformBatch, decode
from fairlead.wire.bus import Bus, Publisher, Qos, Sample
from fairlead_state_assembler.core import AssemblerCore, Output
from fairlead_state_assembler.skill_view import SkillView


class AssemblerTransport:
    """Feeds an `AssemblerCore` from the bus and publishes what it returns.

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
        self._declared = [
            bus.subscribe(keys.every_tf, self._on_transforms),
            bus.subscribe(keys.joints, self._on_joints),
            bus.watch_tokens(keys.every_want_layout, self._on_want),
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

    def _on_want(self, key: str, wanted: bool) -> None:
        skill = last_chunk(key)
        if not wanted:
            with self._lock:
                self._core.unwant(skill)
            self._log.info("no longer assembling for %s", skill)
            return
        view = SkillView(skill)  # reads a file: not under the lock that every tick needs
        with self._lock:
            if skill not in self._layouts:
                self._layouts[skill] = self._bus.publisher(
                    self._keys.layout(skill), LayoutState, Qos.HOT
                )
            outputs = self._core.want(view)
        if view.refusal is not None:
            self._log.error("cannot assemble for %s: %s", skill, view.refusal)
        else:
            self._log.info("assembling for %s", skill)
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
