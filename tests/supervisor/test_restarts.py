"""What may go wrong around a restart takes down no other service, and is said."""

from __future__ import annotations

import asyncio
import os
import signal
from pathlib import Path

import pytest

from fairlead.deploy.process_table import process_id
from fairlead.errors import ConfigError, ServiceError
from tests.supervisor.bench import WAIT_S, Bench, wait_until

pytestmark = pytest.mark.asyncio


@pytest.mark.processes
async def test_a_full_disk_loses_lines_of_the_log_and_nothing_else(bench: Bench) -> None:
    log = bench.state_dir / "logs" / "hal.log"
    log.parent.mkdir(parents=True)
    log.symlink_to("/dev/full")
    go_on = bench.state_dir / "go on"
    bench.scripts["hal"] = (
        f"echo one; echo two; echo 'hal: ready'; while [ ! -e '{go_on}' ]; do sleep 0.05; done; "
        "echo three; exec sleep 1000"
    )
    await bench.start()
    await wait_until(lambda: ("hal", "hal: ready") in bench.lines, "it goes on")
    said = [line for name, line in bench.lines if name == "hal"]
    assert said.count(f"{log}: No space left on device; lines are lost") == 1
    log.unlink()
    go_on.touch()
    await wait_until(lambda: log.is_file() and "three" in log.read_text(), "the log goes on")
    assert log.read_text(encoding="utf-8").endswith("Z PRINT hal: three\n")
    await wait_until(
        lambda: ("hal", f"{log}: written again; 3 lines were lost") in bench.lines, "it is said"
    )
    assert bench.supervisor.last_lines("hal")[:2] == ["one", "two"]
    assert bench.supervisor.died() is None


@pytest.mark.processes
async def test_what_a_full_disk_left_out_of_the_list_is_listed_once_there_is_room(
    bench: Bench,
) -> None:
    await bench.start()
    name = bench.supervisor.name
    draft = bench.registry.folder / f"{name}.draft"
    draft.mkdir()
    bench.keep()
    os.kill(bench.supervisor.pid("runner"), signal.SIGKILL)
    assert (await bench.event("failed")).startswith(f"cannot say what runs here: {draft}: ")
    assert await bench.event("ready") == "runner is ready again"
    draft.rmdir()

    def is_listed() -> bool:
        entry = bench.registry.find(name)
        runner = entry and entry.services["runner"].running
        return bool(runner and runner.pid == bench.supervisor.pid("runner"))

    await wait_until(is_listed, "the new runner is listed")
    assert not any(bench.events.get_nowait().kind == "failed" for _ in range(bench.events.qsize()))


@pytest.mark.processes
async def test_a_service_that_cannot_be_started_again_is_tried_later_and_the_others_live(
    bench: Bench,
) -> None:
    await bench.start()
    runner = bench.supervisor.pid("runner")
    bench.keep()
    bench.problem = ConfigError("robot r: no compiled gate file")
    os.kill(bench.supervisor.pid("hal"), signal.SIGKILL)
    failed = await bench.event("failed")
    assert failed == (
        "hal cannot be started again: robot r: no compiled gate file; next attempt in 1 s"
    )
    bench.problem = RuntimeError("can't start new thread")
    assert "can't start new thread; next attempt in 2 s" in await bench.event("failed")
    bench.problem = None
    assert await bench.event("ready") == "hal is ready again"
    assert bench.supervisor.pid("runner") == runner


@pytest.mark.processes
async def test_a_service_that_was_ready_and_died_while_others_start_is_started_again(
    bench: Bench, tmp_path: Path
) -> None:
    once = tmp_path / "once"
    bench.scripts["hal"] = f"echo 'hal: ready'; [ -e {once} ] && exec sleep 1000; touch {once}"
    bench.scripts["runner"] = (
        f"while [ ! -e {once}2 ]; do sleep 0.05; done; echo 'runner: ready'; exec sleep 1000"
    )
    await bench.supervisor.start()
    bench.keep()
    ready = asyncio.create_task(bench.supervisor.wait_ready(WAIT_S))
    await bench.event("died")
    await bench.event("restarted")
    assert not ready.done()
    tmp_path.joinpath("once2").touch()
    await ready


@pytest.mark.processes
async def test_a_terminal_that_takes_no_lines_keeps_nothing_from_being_started_again_and_ended(
    bench: Bench,
) -> None:
    bench.takes_lines.clear()
    await bench.start()
    bench.keep()
    os.kill(bench.supervisor.pid("hal"), signal.SIGKILL)
    assert await bench.event("ready") == "hal is ready again"
    pid = bench.supervisor.pid("hal")
    assert await bench.supervisor.stop() == []
    assert process_id(pid) is None


@pytest.mark.processes
async def test_a_start_that_takes_too_long_says_how_long_it_waited(bench: Bench) -> None:
    bench.scripts["runner"] = "exec sleep 1000"
    await bench.supervisor.start()
    with pytest.raises(ServiceError, match=r"runner: not ready after 1\.5 s; its last lines"):
        await bench.supervisor.wait_ready(1.5)


@pytest.mark.processes
async def test_a_restart_on_a_changed_file_names_it(bench: Bench, tmp_path: Path) -> None:
    bench.argument = tmp_path / "gate.json"
    bench.argument.write_text("{}", encoding="utf-8")
    await bench.start()
    bench.keep()
    os.kill(bench.supervisor.pid("hal"), signal.SIGKILL)
    assert "CHANGED" not in await bench.event("restarted")
    bench.argument.write_text('{"limit": 10}', encoding="utf-8")
    await bench.event("ready")
    os.kill(bench.supervisor.pid("hal"), signal.SIGKILL)
    text = await bench.event("restarted")
    assert text.endswith(f"#2), CHANGED since its last start: {bench.argument}")


async def test_a_deployment_is_listed_before_its_first_process_is_started(bench: Bench) -> None:
    bench.supervisor.reserve()
    (entry,) = bench.registry.entries()
    assert list(entry.services) == ["hal", "runner"]
    assert [service.process for service in entry.services.values()] == [None, None]
    with pytest.raises(ServiceError, match="is already running"):
        bench.another().reserve()
    await bench.supervisor.stop()
    assert bench.registry.entries() == []


async def test_a_lock_is_one_lock_whoever_ends_in_between(bench: Bench) -> None:
    """Deleting a lock file would leave its holder with a lock that nobody else can see."""
    bench.supervisor.reserve()
    name = bench.supervisor.name
    bench.registry.remove_if_ended(name)
    assert bench.registry.find(name) is not None, "it runs: nothing was forgotten"
    await bench.supervisor.stop()
    with bench.registry.lock(name), pytest.raises(ServiceError, match="is already running"):
        bench.another().reserve()


async def test_what_runs_with_a_damaged_entry_is_ended_by_its_pid(bench: Bench) -> None:
    bench.supervisor.reserve()
    name = bench.supervisor.name
    (bench.registry.folder / f"{name}.json").write_text("{", encoding="utf-8")
    with pytest.raises(ServiceError) as caught:
        bench.another().reserve()
    pid = os.getpid()
    said = f"deployment {name} is already running (pid {pid}); stop it first: kill {pid}"
    assert str(caught.value) == said
    await bench.supervisor.stop()


@pytest.mark.processes
async def test_a_process_group_that_ends_while_it_is_being_ended_is_no_error(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its last process goes between the look and the signal."""
    await bench.start()
    bench.keep()
    monkeypatch.setattr("fairlead_tools.supervisor.child.group_members", lambda group: [group])
    os.kill(bench.supervisor.pid("hal"), signal.SIGKILL)
    assert "was killed by signal 9" in await bench.event("died")
