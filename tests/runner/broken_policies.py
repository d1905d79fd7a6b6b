"""Policies that misbehave in one way each, loaded into a real worker process."""

from __future__ import annotations

import faulthandler
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any, Self

import numpy as np

from fairlead.policy import Done, Failed, Observation
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.policy_wire import HEADER, Answer, Ended, encode


class Misbehaving:
    """Returns eight good rows unless a subclass does worse."""

    probe = False

    def __init__(self, skill: SkillManifest) -> None:
        self.rows = np.zeros((skill.horizon, skill.action_contract.dim), dtype=np.float32)
        self.resets = 0

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, Any]) -> Self:
        return cls(skill)

    def infer(self, observation: Observation) -> np.ndarray:
        return self.rows

    def reset(self) -> None:
        self.resets += 1


class Echo(Misbehaving):
    """Row 0 says what arrived: tick, state[1], prompt length, a pixel, resets so far, the
    answer whose row the base executed, the last tick that was released."""

    def infer(self, observation: Observation) -> np.ndarray:
        pixel = observation.images["eye"][1, 0, 2] if observation.images else -1
        seen = [observation.tick, observation.state[1], len(observation.prompt)]
        self.rows[0, :5] = [*seen, pixel, self.resets]
        if observation.judged is not None:
            base = observation.executed["base"].answer_tick
            self.rows[0, 5:7] = [base, observation.judged.last_tick]
        return self.rows


class Hangs(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        threading.Event().wait()
        return self.rows


class Dies(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        os._exit(7)


class DiesOfSignal(Misbehaving):
    """Of the one whose number is the tick's."""

    def infer(self, observation: Observation) -> np.ndarray:
        faulthandler.disable()
        signal.signal(observation.tick, signal.SIG_DFL)
        os.kill(os.getpid(), observation.tick)
        return self.rows


class DiesAfterFork(Misbehaving):
    """A process that it started lives on, for no longer than a test waits."""

    def infer(self, observation: Observation) -> np.ndarray:
        if os.fork() == 0:
            signal.alarm(20)
            signal.pause()
        os._exit(7)


class Lists(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return [[0.1] * self.rows.shape[1]] * 2  # type: ignore[return-value]


class Raises(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        raise ValueError("no such token")


class RaisesUnheard(Raises):
    def infer(self, observation: Observation) -> np.ndarray:
        sys.stderr.close()
        return super().infer(observation)


class Exits(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        sys.exit("no token")


class TooNarrow(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return self.rows[:, :11]


class TooLong(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return np.concatenate([self.rows, self.rows])


class Flat(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return np.asarray(self.rows[0])


class Doubles(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return self.rows + np.float64(0.1)


class WholeNumbers(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return self.rows.astype(np.int64)


class Objects(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return self.rows.astype(object)


class Nested(Misbehaving):
    def infer(self, observation: Observation) -> Any:
        return [[1.0, [2.0, [3.0]]]]


class Huge(Misbehaving):
    """2.4 GB, of which no page is written here."""

    def infer(self, observation: Observation) -> np.ndarray:
        return np.zeros((50_000_000, self.rows.shape[1]), dtype=np.float32)


class Recurses(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return self.infer(observation)


class Forgets(Misbehaving):
    def infer(self, observation: Observation) -> None:  # type: ignore[override]
        """Without ``return``."""


class Wraps(Misbehaving):
    def infer(self, observation: Observation) -> dict[str, np.ndarray]:  # type: ignore[override]
        return {"actions": self.rows}


class MasksRows(Misbehaving):
    def infer(self, observation: Observation) -> list[np.ndarray]:  # type: ignore[override]
        return [np.ma.masked_array(row, mask=True) for row in self.rows]


class Spells(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        raise ValueError("no \udc80")


class Wordless(Misbehaving):
    """What it raises cannot say what it is."""

    class FaultError(Exception):
        def __str__(self) -> str:
            raise ValueError("no words")

    def infer(self, observation: Observation) -> np.ndarray:
        raise self.FaultError


class Talks(Misbehaving):
    """Writes to the pipe itself, which any code in its process can."""

    said: bytes

    def infer(self, observation: Observation) -> np.ndarray:
        os.write(int(sys.argv[1]), self.said)
        threading.Event().wait()
        return self.rows


def framed(message: bytes) -> bytes:
    return HEADER.pack(len(message)) + message


class TalksNonsense(Talks):
    said = framed(b"\xc1")


class TalksDeeply(Talks):
    """A map whose unknown entry is an array in an array in an array ..."""

    said = framed(b"\x82\xa4type\xa6Answer\xa4deep" + b"\x91" * 50_000 + b"\x90")


class TalksMuch(Talks):
    said = HEADER.pack(4_000_000_000)


class TalksOfRows(Talks):
    said = framed(encode(Answer((8, 12), b"1234")))


class TalksOfOtherRows(Talks):
    said = framed(encode(Answer()))


class TalksOfNoEnd(Talks):
    said = framed(encode(Ended("Object lost!", "")))


class HangsUp(Misbehaving):
    """In the middle of its answer."""

    def infer(self, observation: Observation) -> np.ndarray:
        os.write(int(sys.argv[1]), framed(encode(Answer()))[:-1])
        os.kill(os.getpid(), signal.SIGKILL)
        return self.rows


class NotANumber(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        self.rows[2, 3] = np.nan
        return self.rows


class CannotLoad(Misbehaving):
    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, Any]) -> Self:
        raise FileNotFoundError("weights.bin")


class NeverLoads(Misbehaving):
    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, Any]) -> Self:
        threading.Event().wait()
        return cls(skill)


class StartsAnother(Misbehaving):
    """The other writes a line to the FIFO that CHILD_WRITES names, and lives on."""

    def __init__(self, skill: SkillManifest) -> None:
        super().__init__(skill)
        with Path(os.environ["CHILD_WRITES"]).open("w") as fifo:
            self.starts(["/bin/sh", "-c", "echo; exec sleep 60"], fifo)

    def starts(self, command: list[str], out: IO[str]) -> None:
        subprocess.Popen(command, stdout=out)

    def infer(self, observation: Observation) -> np.ndarray:
        os._exit(7)


class StartsASession(StartsAnother):
    """Of which the other is the child's child, left by its parent."""

    def starts(self, command: list[str], out: IO[str]) -> None:
        parent = ["/bin/sh", "-c", '"$@" & sleep 60 & exit', "sh", "setsid", *command]
        subprocess.Popen(parent, stdout=out, start_new_session=True).wait()


class StartsAnotherAndNeverLoads(StartsAnother):
    def __init__(self, skill: SkillManifest) -> None:
        super().__init__(skill)
        threading.Event().wait()


class StartsASessionAndNeverLoads(StartsAnotherAndNeverLoads, StartsASession):
    """In this order: it starts one, then waits."""


class SaysDone(Misbehaving):
    def infer(self, observation: Observation) -> Done:  # type: ignore[override]
        return Done("the drawer is shut")


class GivesUp(Misbehaving):
    def infer(self, observation: Observation) -> Failed:  # type: ignore[override]
        return Failed("object_lost", "nothing is in the hand")


class GivesUpBadly(Misbehaving):
    def infer(self, observation: Observation) -> Failed:  # type: ignore[override]
        return Failed("Object lost!", "")
