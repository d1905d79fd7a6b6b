"""Which classes have a lock: those listed here, and nobody else takes it."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from tests.repo.tree import python_files, tree

LOCKS = ("Lock", "RLock", "Condition", "Semaphore", "BoundedSemaphore", "Barrier")
GUARDS = {
    "SharedCore": "the HAL's core: `receive`, `tick`",
    "GoalExecutor": "the runner's core: `receive`, `main`",
    "AssemblerTransport": "the assembler's core: `receive`, `main`",
    "EpisodeResetHandler": "a waiting episode reset: `main`, `tick`",
    "Mailbox": "messages that a client's loop has not taken yet",
    "LoopThread": "whether the blocking client is being closed: any thread that calls it",
    "JointStates": "joints of a ROS 2 system: its `receive`, `tick`",
    "LeaderArm": "a leader's newest pose: `leader`, the thread of its bus, and teleop's `main`",
    "HeardStates": "joint states that `fairlead hal check` heard: its `receive`, `main`",
    "StandInGate": "leases that `fairlead hal check` sends: its `receive`, `main`, and a timer",
    "FrameSender": "readers and memory of a camera: `tick`, the camera's thread",
    "FrameThread": "links of cameras: `receive`, `frames`, `main`",
    "FrameSubscription": "which way a camera's frames come: `receive`, `frames`, `main`",
    "CameraProcess": "the number of requested frames: `tick`, the camera's thread",
}
"""What each lock guards, and the threads that take it (tests/system/test_threads.py)."""


def made() -> Iterator[tuple[str, str]]:
    """Class and attribute of each lock between threads; "" where one is made elsewhere."""
    for path in python_files("shared/", "services/"):
        classes = [one for one in ast.walk(tree(path)) if isinstance(one, ast.ClassDef)]
        within = {id(node): one.name for one in classes for node in ast.walk(one)}
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.Assign) and is_lock(node.value):
                yield within.get(id(node), ""), ast.unparse(node.targets[0])


def is_lock(value: ast.expr) -> bool:
    words = ast.unparse(value).partition("(")[0].split(".")
    return isinstance(value, ast.Call) and words[-1] in LOCKS and words[0] != "asyncio"


def test_each_lock_between_threads_is_listed_with_what_it_guards() -> None:
    assert sorted(name for name, _ in made()) == sorted(GUARDS)


def test_a_lock_is_taken_by_its_own_class_alone() -> None:
    names = {attribute.removeprefix("self.") for _, attribute in made()}
    taken = {
        f"{path}: {ast.unparse(item.context_expr)}"
        for path in python_files("shared/", "services/")
        for node in ast.walk(tree(path))
        if isinstance(node, ast.With)
        for item in node.items
        if isinstance(item.context_expr, ast.Attribute)
        and item.context_expr.attr in names
        and ast.unparse(item.context_expr.value) != "self"
    }
    assert taken == set()
