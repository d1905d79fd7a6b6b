"""The documents name what exists: keys, codes, folders, files, scripts."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from pydantic import BaseModel

from bench.pages.__main__ import PAGES
from fairlead.modes import GATED_MODES
from fairlead_hal_kinematic.options import KinematicOptions
from fairlead_hal_mujoco.options import MujocoOptions
from fairlead_hal_ros2.options import Ros2Options
from fairlead_hal_sim.options import HalSimOptions
from fairlead_hal_so101.options import So101Options
from tests.repo.tree import ROOT

DESIGN = (ROOT / "docs" / "design.md").read_text()
READING_THE_GATE = ROOT / "services" / "safety" / "README.md"
KEYS = (ROOT / "tests" / "access" / "keys.md").read_text()
SAFETY = (ROOT / "docs" / "safety-checks.md").read_text()
GOLDEN_KEYS = json.loads((ROOT / "tests" / "golden" / "keys.json").read_text())


def written_key(template: str) -> re.Pattern[str]:
    """A regular expression for the keys that one cell of the key table stands for."""
    escaped = re.escape(template).replace(r"\{", "(").replace(r"\}", ")").replace(",", "|")
    return re.compile("^" + re.sub("<[a-z]+>", "[^/]+", escaped) + "$")


def test_the_key_table_lists_every_key_that_can_be_built_and_no_other() -> None:
    templates = [
        written_key(cell) for cell in re.findall(r"^\| `([^`]+)` \| (?:pub|qu|li)", KEYS, re.M)
    ]
    keys = {
        "/".join(row["key"].split("/")[2:])
        for row in GOLDEN_KEYS
        if "every" not in row["method"] and row["robot"] == "panda_mobile"
    }
    unlisted = {key for key in keys if not any(t.match(key) for t in templates)}
    unused = {t.pattern for t in templates if not any(t.match(key) for key in keys)}
    assert (unlisted, unused) == (set(), set())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_that_is_made_of_the_tests_is_current(page: Path) -> None:
    assert page.read_text() == PAGES[page](), "run: python -m bench.pages --write"


def test_the_modes_with_rules_are_those_of_the_code() -> None:
    table = SAFETY.partition("## Rules by mode\n")[2].partition("\n\n-")[0]
    first = re.findall(r"^\| ([a-z_, ]+) \|", table, re.M)[1:]
    assert set(re.findall(r"\w+", " ".join(first))) == {mode.yaml_name for mode in GATED_MODES}


def test_folders_of_the_design_exist() -> None:
    named = re.findall(r"`([a-z/_]+?)/?`", DESIGN.partition("## Folders")[2])
    folders = [
        name for name in named if name.split("/")[0] in ("services", "shared", "bench", "tests")
    ]
    assert folders
    assert [name for name in folders if not (ROOT / name).exists()] == []


def test_scripts_and_files_named_in_the_documents_exist() -> None:
    missing = [
        f"{path.name}: {name}"
        for path in [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")]
        for name in re.findall(
            r"`((?:scripts|services|shared|compose)/[\w./-]+)`", path.read_text()
        )
        if not (ROOT / name).exists()
    ]
    assert missing == []


def headings(page: Path) -> set[str]:
    """What a link into the page may name: its headings as GitHub writes them in an address."""
    titles = re.findall(r"^#+ (.+)$", page.read_text(), re.M)
    plain = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title) for title in titles)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in plain}


def test_every_link_between_the_documents_leads_somewhere() -> None:
    broken = []
    for page in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), READING_THE_GATE]:
        for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
            if "://" in target:
                continue
            file, _, part = target.partition("#")
            there = (page.parent / file) if file else page
            if not there.exists() or (part and part not in headings(there)):
                broken.append(f"{page.name}: {target}")
    assert broken == []


def test_contributing_is_short() -> None:
    assert (ROOT / "CONTRIBUTING.md").read_text().count("\n") < 60


@pytest.mark.parametrize(
    "options", [HalSimOptions, KinematicOptions, MujocoOptions, Ros2Options, So101Options]
)
def test_every_option_of_a_hal_says_what_it_is(options: type[BaseModel]) -> None:
    text = "\n".join(kind.__doc__ or "" for kind in options.__mro__ if kind is not BaseModel)
    names = re.findall(r"(?:^ *|\. )((?:\w+, )*\w+): ", text, re.M)
    said = {name for name, field in options.model_fields.items() if field.description}
    assert set(options.model_fields) - said - set(", ".join(names).split(", ")) == set()
