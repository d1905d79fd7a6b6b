"""Settings of every test."""

from __future__ import annotations

import atexit
import gc
import os
import re
import shutil
import signal
import sys
import tempfile
import tomllib
import warnings
from collections.abc import Generator
from importlib.metadata import distribution
from pathlib import Path

import pytest
from hypothesis import settings

from tests.late_machine import LATE, current

# A slow machine is no failure: what has a bound in time says so in its own test.
settings.register_profile("fairlead", deadline=None)
settings.load_profile("fairlead")

# Skills that whoever runs the tests has installed are not part of what is tested.
os.environ["FAIRLEAD_SKILLS"] = str(
    Path(tempfile.gettempdir()) / f"fairlead-tests-{os.getuid()}-no-skills"
)

# Passwords and sockets of what tests start lie beside, whatever state folder a command is given:
# this process's own, so that robots of one name in tests that run beside it are others.
_access = Path(tempfile.gettempdir()) / f"fairlead-tests-{os.getuid()}-{os.getpid()}-access"
os.environ["FAIRLEAD_ACCESS"] = str(_access)
atexit.register(shutil.rmtree, _access, ignore_errors=True)

# A shell starts what it runs in the background with Ctrl-C ignored, and children inherit that:
# the processes that tests interrupt must hear it wherever the tests were started.
signal.signal(signal.SIGINT, signal.default_int_handler)

# What is registered in pyproject.toml is found in the metadata of the installation.
_project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text("utf-8"))
_registered = {(one.group, one.name, one.value) for one in distribution("fairlead").entry_points}
for _group, _named in _project["project"]["entry-points"].items():
    if not {(_group, name, value) for name, value in _named.items()} <= _registered:
        pytest.exit(f"{_group} in pyproject.toml has changed; install it: scripts/setup", 2)

# A test's marks say what it starts, so that `make check` can leave it out; one that starts more
# than it says fails. `git`, which lists the files here, does not count, nor does the process in
# which glfw, imported by mujoco, asks for its library's version.
_running: list[pytest.Item] = []
SIMULATOR = re.compile(r"^robosuite$|/robosuite/.*\.xml$")  # the package, or a model that it loads


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if "processes" in item.keywords:
            item.add_marker(LATE)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    _running.append(item)
    try:
        return (yield)
    finally:
        _running.pop()


# pytest-timeout limits the first try alone: without this, one that is tried again could hang.
_limits: dict[str, object] = {}


@pytest.hookimpl(tryfirst=True)
def pytest_timeout_set_timer(item: pytest.Item, settings: object) -> None:
    _limits[item.nodeid] = settings


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    current["try"] = getattr(item, "execution_count", 1)
    if current["try"] > 1:
        item.ihook.pytest_timeout_set_timer(item=item, settings=_limits[item.nodeid])


_failed: set[str] = set()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """What a test printed and logged, as a file would have it: pytest-xdist hands on UTF-8 alone,
    and the worker of a test that logged a lone surrogate would end without a word."""
    report = yield
    report.sections = [
        (title, text.encode("utf-8", "backslashreplace").decode("utf-8"))
        for title, text in report.sections
    ]
    return report


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if report.outcome not in ("passed", "skipped"):  # failed, or to be run again
        _failed.add(report.nodeid)


def pytest_runtest_logfinish(nodeid: str) -> None:
    """What a failed test left open is its own failure, not that of the test after it."""
    if nodeid not in _failed:
        return
    _failed.remove(nodeid)
    for name in ("last_type", "last_value", "last_traceback", "last_exc"):
        vars(sys).pop(name, None)  # pytest leaves its frames there for a debugger
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        gc.collect()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Why each test that was tried again had failed."""
    for report in terminalreporter.stats.get("rerun", ()):
        crash = getattr(report.longrepr, "reprcrash", None)
        why = " ".join(str(crash.message if crash else report.longrepr).split())
        terminalreporter.write_line(f"AGAIN {report.nodeid}: {why[:600]}")


def _refuse_what_is_not_marked(event: str, arguments: tuple[object, ...]) -> None:
    if not _running:
        return
    needed = ""
    if event in ("subprocess.Popen", "os.posix_spawn", "os.fork", "os.system"):
        allowed = (arguments and arguments[0] == "git") or "glfwGetVersion" in str(arguments)
        needed = "" if allowed else "processes"
    elif event in ("import", "open") and SIMULATOR.search(str(arguments[0])):
        needed = "simulator"
    if needed and needed not in _running[-1].keywords:
        name, what = _running[-1].nodeid, arguments[:2] or event
        raise RuntimeError(f"{name}: expected the mark `{needed}` of a test that starts {what}")


sys.addaudithook(_refuse_what_is_not_marked)
