"""Asks the policy on a thread of its own, so that no message waits for a policy."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable

from fairlead.errors import PolicyError
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_skill_runner.run_core import AskPolicy, PolicyAnswer

AnswerHandler = Callable[[AskPolicy, PolicyAnswer], None]


class InferenceThread:
    """One question at a time, for one goal; answers go to ``handler`` on this thread."""

    def __init__(self, worker: PolicyWorker, handler: AnswerHandler) -> None:
        self._worker = worker
        self._handler = handler
        self._questions: queue.SimpleQueue[AskPolicy | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="inference", daemon=True)
        self._thread.start()

    def ask(self, question: AskPolicy) -> None:
        """Queue a question; returns at once."""
        self._questions.put(question)

    def close(self) -> None:
        """Take no more questions and wait for the one that is running."""
        self._questions.put(None)
        self._thread.join()

    def _run(self) -> None:
        while (question := self._questions.get()) is not None:
            answer: PolicyAnswer
            try:
                answer = self._worker.infer(question.observation)
            except PolicyError as error:
                logging.getLogger("policy").error("%s", error)
                answer = error
            self._handler(question, answer)
