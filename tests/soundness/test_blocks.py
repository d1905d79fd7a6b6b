"""Campaigns cut into blocks, and put together again."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from bench.soundness.blocks import Block, blocks_of, kept_work, merged
from bench.soundness.followed import Soundness
from bench.soundness.simulated_campaign import Simulated
from bench.soundness.usability import Usability


def test_an_amount_is_cut_into_blocks_of_their_own_numbers() -> None:
    assert blocks_of("panda", "usability", 12) == [
        Block("panda", "usability", 0, 5),
        Block("panda", "usability", 1, 5),
        Block("panda", "usability", 2, 2),
    ]
    assert blocks_of("panda", "kinematic", 0) == []
    assert blocks_of("panda", "usability", 6, 400) == [
        Block("panda", "usability", 400, 5),
        Block("panda", "usability", 401, 1),
    ]


def test_what_blocks_found_is_added_up_and_the_least_room_is_kept() -> None:
    one = Simulated(rows=200, breaches=Counter(bounds=1), told=["a"])
    other = Simulated(rows=50, breaches=Counter(bounds=2, zones=1), told=["b"])
    one.worst["bounds"], other.worst["bounds"] = 0.25, -0.5
    whole = merged([one, other])
    assert (whole.rows, whole.told) == (250, ["a", "b"])
    assert whole.breaches == {"bounds": 3, "zones": 1}
    assert whole.worst["bounds"] == -0.5


@pytest.mark.processes
def test_a_block_that_is_kept_is_not_done_again(tmp_path: Path) -> None:
    block = Block("panda", "usability", 0, 1)
    first = kept_work(block, tmp_path)
    assert isinstance(first, Usability) and first.succeeded == 1
    (file,) = tmp_path.iterdir()
    file.write_bytes(file.read_bytes().replace(b"chunks", b"chunk_"))
    again = kept_work(block, tmp_path)
    assert not hasattr(first, "chunk_") and hasattr(again, "chunk_")


def test_a_place_that_is_no_number_is_a_breach() -> None:
    found = Soundness()
    found.see("bounds", 0.1, "inside")
    assert not found.breaches
    found.see("bounds", float("nan"), "nowhere")
    assert found.breaches == {"bounds": 1} and found.told == ["bounds nan: nowhere"]
