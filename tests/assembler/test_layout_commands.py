"""``fairlead layout``: what it lists, what it verifies, and what it refuses."""

import json
from pathlib import Path

import pytest

from tests.assembler.every_layout import LAYOUT_DIMS, LAYOUTS
from tests.cli.command import fairlead_here as fairlead


def test_ls_says_width_needs_and_content_and_that_gr1_has_no_assembler(tmp_path: Path) -> None:
    done = fairlead("layout", "ls", "--json", state=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = {row["layout"]: row for row in json.loads(done.stdout)}
    assert {name: row["dim"] for name, row in rows.items()} == LAYOUT_DIMS | {"gr1": None}
    needs = {name: row["required_bindings"] for name, row in rows.items()}
    assert needs == {name: list(one.required) for name, one in LAYOUTS.items()}
    assert rows["gr1"]["content"] == "no assembler"
    assert rows["libero"]["content"] == (
        "joints of one Franka arm, fingers (LIBERO's own baselines)"
    )


@pytest.mark.simulator
def test_verify_takes_a_layout_instead_of_a_skill(tmp_path: Path) -> None:
    words = ("--layout", "libero_eef8d", "--ticks", "3", "--json")
    done = fairlead("layout", "verify", *words, state=tmp_path)
    report = json.loads(done.stdout)
    assert (done.returncode, report["layout"], report["ok"]) == (0, "libero_eef8d", True)
    assert [field["field"] for field in report["fields"]] == [
        "world_to_eef position",
        "world_to_eef rotation",
        "gripper",
    ]


@pytest.mark.simulator
@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ((), "layout verify: expected a skill or --layout, got both or neither"),
        (
            ("oracle-counter-to-cabinet", "--layout", "rc365"),
            "layout verify: expected a skill or --layout, got both or neither",
        ),
        (
            ("panda-joint-reach",),
            "layout verify: robot panda: no deployment in compose/ simulates it in robosuite (run: "
            "hal_sim), whose observations are the truth to compare with",
        ),
        (
            ("--layout", "gr2"),
            "layout verify: expected a layout, got 'gr2' (valid: aloha, base_pose_6d, gr1, "
            "human300_16d, libero, libero_eef8d, mobile_pick_30d, panda_omron_53d, rc365 from "
            "fairlead 0.1.0)",
        ),
        (
            ("--layout", "gr1"),
            "layout verify: layout gr1 has no assembler",
        ),
        (
            ("--layout", "aloha"),
            "layout verify: layout aloha names no fields that the simulator knows the truth of",
        ),
    ],
)
def test_what_cannot_be_verified_is_refused(
    words: tuple[str, ...], complaint: str, tmp_path: Path
) -> None:
    done = fairlead("layout", "verify", *words, state=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"ERROR {complaint}\n"
