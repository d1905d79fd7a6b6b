"""What `robot compile` takes, the gate takes: their ranges, compared at each end."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fairlead.hal.inbox import GATE_READS
from fairlead.hal.lease_follower import LEASE_LIFE_NS
from fairlead.paths import gate_binary, gate_config, repo_root
from fairlead.robot.capsules import MAX_CAPSULES, MAX_PAIRS
from fairlead.robot.gate_file import MAX_FRAMES, MAX_NAME, MAX_SOURCE, MOST, sealed
from fairlead.robot.mode_limits import MOST_GAIN
from fairlead.robot.safety_profile import Protocol
from fairlead.robot.surroundings import MAX_CORNERS, MAX_VOLUMES, MAX_ZONES

pytestmark = pytest.mark.processes

HEADERS = repo_root() / "services" / "safety" / "include" / "fairlead_safety"
NARROWER = {"lease_interval_ms": "leases have to come well within the HAL's 75 ms"}
"""Upper ends at which the compiler refuses on purpose what the gate would take."""


def gate_takes(document: dict[str, Any], folder: Path) -> tuple[bool, str]:
    file = folder / "gate.json"
    file.write_text(sealed(json.dumps(document)))
    asked = [str(gate_binary()), "check", str(file)]
    done = subprocess.run(asked, capture_output=True, text=True, check=False)
    return done.returncode == 0, done.stdout


@pytest.fixture
def document() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(gate_config("panda_mobile", "sim").read_text())
    return found


def ends(name: str) -> Iterator[tuple[float, float, str]]:
    """The compiler's lowest and highest value of a key, each with what lies just beyond."""
    field = Protocol.model_fields[name]
    whole = field.annotation in (int, int | None)
    for bound in field.metadata:
        for end, side in (("ge", -1), ("le", 1)):
            value = getattr(bound, end, None)
            if value is not None:
                yield value, value + side * (1 if whole else 1e-6), end


@pytest.mark.parametrize("name", Protocol.model_fields)
def test_the_protocols_ranges_are_the_gates(
    name: str, document: dict[str, Any], tmp_path: Path
) -> None:
    protocol = document["protocol"]
    found = list(ends(name))
    assert {end for _, _, end in found} == {"ge", "le"}
    for value, beyond, end in found:
        # Where one bounds another, the other makes room.
        protocol |= {"step_deadline_us": 1} if name == "state_timeout_ms" else {}
        protocol |= {"state_timeout_ms": 10_000} if name == "step_deadline_us" else {}
        protocol[name] = value
        taken, said = gate_takes(document, tmp_path)
        assert taken, f"the gate refuses what is compiled: {said}"
        protocol[name] = beyond
        taken, said = gate_takes(document, tmp_path)
        assert taken == (end == "le" and name in NARROWER), f"{name} {beyond}: {said}"
        assert taken or f"protocol.{name}" in said


def test_lists_have_as_much_room_as_the_gate_has() -> None:
    text = "".join(path.read_text() for path in sorted(HEADERS.glob("*limits.hpp")))
    room = {
        name: int(size)
        for name, size in re.findall(r"inline constexpr std::size_t (max_\w+) = (\d+);", text)
    }
    assert (
        room
        | {
            "max_joints": MOST["joints"],
            "max_passive": MOST["passive_joints"],
            "max_links": MOST["kinematics.links"] + 1,  # the root is none of the list
            "max_parts": MOST["parts"],
            "max_frames": MAX_FRAMES,
            "max_capsules": MAX_CAPSULES,
            "max_capsule_pairs": MAX_PAIRS,
            "max_volumes": MAX_VOLUMES,
            "max_zones": MAX_ZONES,
            "max_corners": MAX_CORNERS,
            "max_rows": max(value for value, _, end in ends("horizon_max") if end == "le"),
        }
        == room
    )


def test_texts_may_be_as_long_as_the_gate_keeps_them(
    document: dict[str, Any], tmp_path: Path
) -> None:
    """A longer source would be cut and cited wrongly, a longer name is refused."""
    kept = re.search(r"using Text = FixedText<(\d+)>;", (HEADERS / "fixed.hpp").read_text())
    assert kept is not None and int(kept[1]) == MAX_SOURCE
    for size, fits in ((MAX_NAME, True), (MAX_NAME + 1, False)):
        document["workspace"]["volumes"][0]["name"] = "x" * size
        taken, said = gate_takes(document, tmp_path)
        assert taken == fits, said


def test_the_largest_share_of_a_gain_is_the_gates(document: dict[str, Any], tmp_path: Path) -> None:
    [base] = [part for part in document["parts"] if part["name"] == "base"]
    for upper, fits in ((MOST_GAIN, True), (MOST_GAIN + 1e-6, False)):
        base["modes"]["joint_velocity"]["gain"] = [0.1, upper]
        taken, said = gate_takes(document, tmp_path)
        assert taken == fits, said


def test_a_mode_of_more_frames_than_the_gate_has_room_for_is_refused(
    document: dict[str, Any], tmp_path: Path
) -> None:
    delta = document["parts"][0]["modes"]["cartesian_delta"]
    links = [link["name"] for link in document["kinematics"]["links"]]
    for count, fits in ((MAX_FRAMES, True), (MAX_FRAMES + 1, False)):
        delta["frames"] = links[:count]
        taken, said = gate_takes(document, tmp_path)
        assert taken == fits, said


def test_the_gate_counts_on_a_lease_for_as_long_as_the_hal_follows_it() -> None:
    source = repo_root() / "services" / "safety" / "src" / "core" / "gate" / "hal_link.cpp"
    [found] = re.findall(r"grant_ns = ([\d']+);", source.read_text())
    assert int(found.replace("'", "")) == LEASE_LIFE_NS


def test_the_hal_knows_how_long_a_stop_the_gate_reads() -> None:
    found = re.findall(r"max_frame_bytes = (\d+);", (HEADERS / "limits.hpp").read_text())
    assert found == [str(GATE_READS)]
