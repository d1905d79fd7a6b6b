"""The same pictures through dora-rs, if it is there, in an environment of its own."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from pathlib import Path

import yaml

from bench.image_move.pictures import Case
from fairlead.paths import repo_root

VERSION = "1.1.0"
_TIMEOUT_S = 300.0


def environment() -> Path:
    """Where it is to be: build/dora of this checkout, or where DORA says."""
    named = os.environ.get("DORA")
    return Path(named) if named else repo_root() / "build" / "dora"


def why_absent() -> str:
    """What to do to have it; "" if it is there."""
    folder = environment()
    if (folder / "bin" / "dora").exists():
        return ""
    return (
        f"no dora-rs in {folder}: scripts/uv venv {folder} --python .venv/bin/python; scripts/uv "
        f"pip install --python {folder}/bin/python dora-rs=={VERSION} dora-rs-cli=={VERSION} numpy"
    )


def dora(case: Case, count: int) -> list[float]:
    """A dataflow of two Python nodes, run by ``dora run``.

    Raises:
        SystemExit: it failed, with its last lines.
    """
    with tempfile.TemporaryDirectory() as folder:
        result, flow = Path(folder) / "result.json", Path(folder) / "flow.yml"
        outputs = [f"camera{number}" for number in range(case.cameras)]
        flow.write_text(yaml.safe_dump({"nodes": [
            _node("send", case, count, result) | {"outputs": outputs},
            _node("receive", case, count, result)
            | {"inputs": {name: f"send/{name}" for name in outputs}},
        ]}))  # fmt: skip
        done = subprocess.run(
            [environment() / "bin" / "dora", "run", flow], cwd=folder, timeout=_TIMEOUT_S,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
        )  # fmt: skip
        if not result.exists():
            last = "\n".join(done.stdout.splitlines()[-20:])
            raise SystemExit(f"bench.image_move: dora ended with {done.returncode}:\n{last}")
        found: list[float] = json.loads(result.read_text())
        return found


def _node(end: str, case: Case, count: int, result: Path) -> dict[str, object]:
    script = f"-u -m bench.image_move.dora_node {end} '{case.name}' {count} {result}"
    return {
        "id": end,
        "path": str(environment() / "bin" / "python"),
        "args": script,
        "env": {"PYTHONPATH": str(repo_root())},
    }
