"""The benches of core and hop run, and their tables find their place; no time is judged here."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from bench.page import write_table
from fairlead.paths import gate_config, repo_root

ROWS = ("H=1", "H=16", "H=50")


@pytest.mark.soak  # compiles the bench
@pytest.mark.processes
def test_the_core_bench_releases_every_chunk_that_it_times() -> None:
    words = [sys.executable, "-m", "bench.gate_core", "--json", "--no-instructions"]
    words += ["--rounds", "2", "--ticks", "3"]
    done = subprocess.run(words, cwd=repo_root(), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    names = {one["name"] for one in found["cases"]}
    assert names == {f"{kind} {rows}" for kind in ("limits", "all checks") for rows in ROWS}
    assert all(one["least_ns"] > 0 for one in found["cases"])
    assert set(found["steps"]) == {
        f"{chunk}, {pacing}, rows that {motion}"
        for chunk in ("joint targets", "all parts")
        for pacing in ("lockstep", "realtime")
        for motion in ("hold", "oscillate")
    }


@pytest.mark.processes
def test_the_hop_bench_gets_every_chunk_released_that_it_times() -> None:
    words = [sys.executable, "-m", "bench.gate_hop", "--json", "--rows", "2"]
    words += ["--count", "3", "--count-20hz", "2"]
    done = subprocess.run(words, cwd=repo_root(), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    for case in ("joint targets, H=2", "tool steps, H=2"):
        for cadence in ("back_to_back", "at_20_hz"):
            assert found[case][cadence]["ratio_p50"] > 0


@pytest.mark.soak  # compiles the bench
@pytest.mark.processes
def test_the_search_for_the_slowest_step_finds_chunks_that_are_judged_row_by_row() -> None:
    config = gate_config("panda", "sim")
    words = [sys.executable, "-m", "bench.gate_core", "--worst", "1", "--json"]
    words += ["--config", str(config)]
    done = subprocess.run(words, cwd=repo_root(), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (found,) = json.loads(done.stdout).values()
    assert found["step_deadline_us"] == 100_000  # as the file says
    assert found["attacks"] >= 2 * 8 * 100  # eight climbs for each of two goals begin with so many
    # A chunk whose first row is refused is looked at some ten times; 4,096 and the rest of a
    # branch's row is the bound.
    assert 500 < found["most_configurations"] < 5_000
    assert found["most_configurations_us"] > 0
    assert 0 < found["chunk_us"] <= found["tick_us"]
    assert 0 < found["state_us"] <= found["tick_us"]


def test_a_table_replaces_the_one_between_its_marks(tmp_path: Path) -> None:
    page = tmp_path / "speed.md"
    page.write_text("before\n<!-- core -->\n| old |\n<!-- end of core -->\nafter\n")
    write_table("core", "| new |", page)
    write_table("core", "| newer |", page)
    text = page.read_text()
    assert text.startswith("before\n<!-- core -->\n| newer |\n\nMeasured 2")
    assert text.endswith("<!-- end of core -->\nafter\n")
    assert ", load " in text
    assert "| new |" not in text
    assert "| old |" not in text


def test_a_page_without_marks_is_left_as_it_is(tmp_path: Path) -> None:
    page = tmp_path / "speed.md"
    page.write_text("no marks")
    with pytest.raises(SystemExit, match="has no marks <!-- core -->"):
        write_table("core", "| new |", page)
    assert page.read_text() == "no marks"


def test_the_page_has_a_place_for_every_table() -> None:
    text = (repo_root() / "docs" / "speed.md").read_text()
    for name in ("steps", "worst", "hop"):
        assert text.count(f"<!-- {name} -->") == text.count(f"<!-- end of {name} -->") == 1
