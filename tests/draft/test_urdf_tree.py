"""A URDF whose links and joints are no one tree is refused by their names, before anything else."""

from __future__ import annotations

import pytest

from tests.draft.drafting import Desk

LIMIT = '<limit lower="-1" upper="1" velocity="2" effort="5"/>'


def link(name: str) -> str:
    return f'<link name="{name}"/>'


def joint(name: str, parent: str, child: str) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="revolute">{ends}<axis xyz="0 0 1"/>{LIMIT}</joint>'


A_TO_C = link("a") + link("b") + link("c") + joint("j", "a", "b") + joint("k", "b", "c")
MANY = link("l0") + "".join(link(f"l{n}") + joint(f"j{n}", f"l{n - 1}", f"l{n}")
                            for n in range(1, 50))  # fmt: skip


@pytest.mark.parametrize(
    ("inside", "said"),
    [
        (A_TO_C + link("b"), "link 'b' is declared 2 times"),
        (A_TO_C.replace('"k"', '"j"'), "joint 'j' is declared 2 times"),
        (A_TO_C + joint("m", "c", "a"), "one link that hangs on no joint, got none: they are"),
        (A_TO_C.replace(' name="k"', ""), "a name for each joint, got none"),
        (A_TO_C.replace('"c"', '""'), "a name for each link, got none"),
        (MANY, "at most 48 joints that move, got 49"),
    ],
)  # fmt: skip
def test_what_is_no_tree_of_names_is_refused(inside: str, said: str, desk: Desk) -> None:
    (desk.folder / "arm.urdf").write_text(f'<robot name="r">{inside}</robot>')
    done = desk.new("mine", "--urdf", "arm.urdf")
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith("ERROR robot new: --urdf: arm.urdf: "), (
        done.stderr
    )
    assert said in done.stderr
    assert not (desk.robots / "mine").exists()
