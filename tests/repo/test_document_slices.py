"""Code in the layouts document is a slice of a file that runs."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
import yaml

from fairlead.layout import load_layout
from fairlead.skill.state_contract import StateContract
from tests.repo.tree import ROOT

TEXT = (ROOT / "docs" / "layouts.md").read_text()
SLICES = re.findall(r"`([\w/]+\.\w+)`:\n\n```(?:python|yaml)\n(.*?)```", TEXT, re.S)


def test_every_block_of_code_names_its_file() -> None:
    assert len(SLICES) == len(re.findall(r"^```(?:python|yaml)$", TEXT, re.M)) == 3


@pytest.mark.parametrize(("path", "code"), SLICES, ids=[path for path, _ in SLICES])
def test_block_is_a_slice_of_its_file(path: str, code: str) -> None:
    assert code.strip() in (ROOT / path).read_text()


@pytest.mark.processes
def test_notebook_example_prints_what_the_document_says() -> None:
    done = subprocess.run(
        [sys.executable, "docs/examples/layout_in_a_notebook.py"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    [printed] = re.findall(r"It prints:\n\n```text\n(.*?)```", TEXT, re.S)
    assert done.stdout == printed


def test_bindings_for_libero_are_the_layouts_example() -> None:
    text = (ROOT / "docs" / "examples" / "libero_eef8d_bindings.yaml").read_text()
    contract = StateContract.model_validate(yaml.safe_load(text))
    assert contract.bindings == load_layout("libero_eef8d").example


def test_the_hal_that_extending_shows_is_a_slice_of_the_example() -> None:
    [shown] = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "extending.md").read_text(), re.S)
    assert shown.strip() in (ROOT / "docs/examples/acme_arm/acme_arm/hal.py").read_text()
