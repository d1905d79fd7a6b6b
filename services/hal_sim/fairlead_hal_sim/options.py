"""Options of ``run: hal_sim`` in a deployment file: environment, robot, cameras, trace."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field, model_validator

from fairlead.errors import expected
from fairlead.plugins import HALS


class CameraOptions(BaseModel):
    """One rendered camera: image size [px] and ticks between frames.

    jpeg_quality: its frames are sent as JPEG of this quality; None: as they are.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    width: int = Field(gt=0, le=4096)
    height: int = Field(gt=0, le=4096)
    period_ticks: int = Field(gt=0)
    jpeg_quality: int | None = Field(default=None, ge=1, le=100)


class SimulatorOptions(BaseModel):
    """What to simulate. Every name is robosuite's own."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    env: str = Field(default="MobilePickPlace", description="a registered environment")
    robot: str = Field(default="PandaOmron", description="a registered robot")
    controller: str | None = Field(
        default=None, description="composite controller, name or path; None: the robot's own"
    )
    part_order: tuple[str, ...] | None = Field(
        default=None, description="simulator parts in vector order; None: the robot's own"
    )
    joint_speed_guard: float | None = Field(
        default=None,
        gt=0,
        description="slow an arm's joints down above this [rad/s]; None: the simulator's own",
    )
    seed: int = Field(default=0, ge=0, description="of the first episode")
    tracked_bodies: dict[str, str] = Field(
        default_factory=dict,
        description="bodies whose transforms are published, by frame of `tracked_frames`",
    )
    cameras: tuple[CameraOptions, ...] = Field(default=(), description="those that are rendered")
    imports: tuple[str, ...] = Field(
        default=(), description="modules that register further environments, such as robocasa"
    )
    env_options: dict[str, Any] = Field(
        default_factory=dict, description="further keyword arguments of the environment"
    )


class HalSimOptions(SimulatorOptions):
    """A simulator's options and those of the process around it.

    trace: also record every step's vector and the simulator's state (``trace.jsonl``).
    """

    trace: bool = False

    @model_validator(mode="before")
    @classmethod
    def _has_no_backend(cls, data: Any) -> Any:
        """Another simulator is another HAL; it was an option once."""
        if isinstance(data, dict) and "backend" in data:
            choices = [f"run: {name}" for name in HALS.names()]
            what = "none, as `run` chooses the HAL"
            raise ValueError(expected("backend", what, repr(data["backend"]), choices))
        return data
