"""Who runs for long says that certificates end, and how they are made anew."""

from __future__ import annotations

import asyncio
import logging
from datetime import timedelta
from pathlib import Path

import pytest

from fairlead.deploy.access_warnings import warn_daily
from fairlead.deploy.deployment import Deployment
from fairlead_tools.certificates.authority import Authority
from tests.access.certified import DAYS, NOW
from tests.access.spoken import assert_says, running
from tests.cli.command import fairlead_here

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
