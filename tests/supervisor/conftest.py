"""A supervisor of two scripts."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
import yaml

from tests.supervisor.bench import Bench


@pytest.fixture
def deployment_file(tmp_path: Path) -> Path:
    content = {
        "robot": "panda_mobile",
        "id": f"r{os.getpid()}",
        "services": {
            "hal": {"run": "hal_sim"},
            "runner": {"run": "skill_runner"},
        },
    }
    path = tmp_path / "deployment.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return path


@pytest_asyncio.fixture
async def bench(deployment_file: Path, tmp_path: Path) -> AsyncIterator[Bench]:
    bench = Bench(deployment_file, tmp_path)
    yield bench
    await bench.end()
