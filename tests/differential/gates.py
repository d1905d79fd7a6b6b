"""The robots whose gate files are tested, each with its reference and its real core."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from bench.equipment.case import Case
from bench.equipment.core_gate import Answer, CoreGate
from fairlead.messages import Outcome
from fairlead.paths import gate_config, robot_dir
from tests.differential.comparison import Difference, differences, rulings
from tests.differential.gate_file import GateFile, read_gate_file
from tests.differential.quiet import write_quiet
from tests.differential.reference import Ruling

ROBOTS = ("panda", "panda_mobile", "dual_panda")
MORE_FRAMES = "dual_panda with more frames"
FEW_CHANGES = "panda_mobile with few changes"


@dataclass(frozen=True)
class Pair:
    """Both judges of one robot."""

    robot: str
    config: Path
    file: GateFile
    core: CoreGate

    def differences(self, case: Case) -> list[Difference]:
        return differences(self.file, case, rulings(self.file, case), self.core.answers(case))

    def answers(self, case: Case) -> list[Answer]:
        return self.core.answers(case)

    def signature(self, case: Case) -> tuple[object, ...]:
        """What kind of disagreement it is, so that a smaller case still shows the same."""
        codes = [_code(ruling) for ruling in rulings(self.file, case)]
        return (*codes, *sorted({found.field for found in self.differences(case)}))


def _code(ruling: Ruling) -> tuple[Outcome, int]:
    return ruling.outcome, ruling.fault.code if ruling.fault else 0


def with_more_frames(config: Path, folder: Path) -> Path:
    """dual_panda's gate file with two more frames for tools: one that is fixed and turned, one
    that moves with the other arm."""
    data = json.loads(config.read_text())
    for part in data["parts"]:
        for name, block in part["modes"].items():
            if name.startswith("cartesian_"):
                other = "right" if part["name"] == "left_arm" else "left"
                block["frames"] += ["left_link0", f"{other}_link2"]
    path = folder / "gate.frames.json"
    path.write_text(json.dumps(data))
    return path


def with_few_changes(config: Path, folder: Path) -> Path:
    """panda_mobile's gate file with one transition, of the base, and a composite switch that turns
    at standstill only."""
    data = json.loads(config.read_text())
    for part in data["parts"]:
        is_base = part["name"] == "base"
        part["transitions"] = [["joint_velocity", "body_twist"]] if is_base else []
        if "composite_mode" in part["modes"]:
            part["modes"]["composite_mode"]["switching"] = "at_standstill"
    path = folder / "gate.changes.json"
    path.write_text(json.dumps(data))
    return path


@contextmanager
def pair_of(robot: str, config: Path | None = None) -> Iterator[Pair]:
    """Reference and core of a robot, by default on its committed gate file; shape and surroundings
    are kept quiet: `test_paths` has them; `test_motion` has tracking and contact."""
    with tempfile.TemporaryDirectory() as folder:
        path = write_quiet(config or gate_config(robot, "sim"), Path(folder))
        core = CoreGate(path)
        try:
            yield Pair(robot, path, read_gate_file(path, robot_dir(robot) / f"{robot}.urdf"), core)
        finally:
            core.close()
