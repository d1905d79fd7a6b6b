"""The HAL host: everything a HAL does except talking to its robot.

The names below are the contract with a robot or a simulator. `fairlead.hal.process` makes
a process of a `Backend`; ``docs/examples/minimal_hal.py`` is a complete one.
"""

from fairlead.hal.backend import (
    Backend,
    BackendDescription,
    CameraFeed,
    FrameModel,
    FramePose,
    Measurement,
    PartCommand,
    TaskReading,
    describe_part,
)

__all__ = [
    "Backend",
    "BackendDescription",
    "CameraFeed",
    "FrameModel",
    "FramePose",
    "Measurement",
    "PartCommand",
    "TaskReading",
    "describe_part",
]
