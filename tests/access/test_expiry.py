"""Who runs for long says that certificates end, and how they are made anew."""

from __future__ import annotations

import asyncio
import logging
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from pathlib import Path

import pytest

from fairlead.deploy.access_warnings import warn_daily
from fairlead.deploy.deployment import Deployment
from fairlead_tools.certificates.authority import Authority
from tests.access.certified import DAYS, NOW
from tests.cli.command import fairlead_command, fairlead_environment, fairlead_here

GATES = ("robot", "safety")
"""Of the gate, which is no Python: others say it for it."""
SOON = "certificate of robot/safety ends in 9 days; where it was made: fairlead certs renew"


def test_certs_new_names_what_it_does_not_renew(
    authority: Authority, file: Path, tmp_path: Path
) -> None:
    authority.renew([GATES], NOW - timedelta(days=400), DAYS)
    done = fairlead_here("certs", "new", str(file), state=tmp_path)
    assert done.returncode == 0, done.stderr
    made, warned = done.stdout.splitlines()
    assert made == "made nothing: there is one for every name"
    assert warned.startswith("WARNING certificate of robot/safety ended ")
    assert warned.endswith("; where it was made: fairlead certs renew")


@contextmanager
def running(tmp_path: Path, *words: str) -> Iterator[subprocess.Popen[str]]:
    """A command, asked to end at the end."""
    with subprocess.Popen(
        fairlead_command(*words), env=fairlead_environment(tmp_path), text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    ) as process:  # fmt: skip
        try:
            yield process
        finally:
            process.terminate()


def assert_says(process: subprocess.Popen[str], end: str) -> None:
    """Wait for a line with this end; the test's time ends if it never comes."""
    assert process.stdout is not None
    assert any(line.endswith(f"{end}\n") for line in process.stdout), f"ended without: {end}"


@pytest.mark.processes
@pytest.mark.timeout(120)
def test_the_router_and_services_log_at_their_start_what_ends_soon(
    authority: Authority, file: Path, tmp_path: Path
) -> None:
    authority.renew([GATES], NOW, 10)
    with running(tmp_path, "router", str(file)) as router:
        assert_says(router, f"WARNING router: {SOON}")
        words = ["service", str(file), "state_assembler", "--state-dir", str(tmp_path / "s")]
        with running(tmp_path, *words) as assembler:
            assert_says(assembler, f"WARNING fairlead-state-assembler: {SOON}")


def test_it_is_logged_again_each_day(
    authority: Authority, deployment: Deployment, caplog: pytest.LogCaptureFixture
) -> None:
    authority.renew([GATES], NOW, 10)

    async def two_days() -> None:
        logging_ = asyncio.create_task(warn_daily([deployment], logging.getLogger(), every_s=1e-3))
        while len(caplog.messages) < 2:  # noqa: ASYNC110 - a log has no event
            await asyncio.sleep(1e-3)
        logging_.cancel()

    asyncio.run(asyncio.wait_for(two_days(), 30.0))
    assert set(caplog.messages) == {SOON}
