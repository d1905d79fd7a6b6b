"""What the refusal of a chunk that came too late says of its policy: how long it took, and may."""

from __future__ import annotations

from fairlead.messages import Verdict

TOO_OLD = 6
"""G006."""


def late_words(verdict: Verdict, waited_ticks: int, took_s: float, period_s: float) -> str:
    """To go behind a verdict's words; "" where no slow policy is the cause.

    Args:
        waited_ticks: from the observation to the chunk.
        took_s: the policy's answer.
        period_s: a control period.
    """
    if verdict.code != TOO_OLD or verdict.value <= verdict.limit or waited_ticks <= 0:
        return ""
    # The rest of the age: inputs that were old when the policy was asked, and the way to the gate.
    may_s = max(0.0, verdict.limit - (verdict.value - waited_ticks)) * period_s
    return (
        f"; the policy is slow: it answered after {took_s:.2f} s and has {may_s:.2f} s: "
        f"age_max_ticks, {verdict.limit:g} of {period_s * 1000:g} ms, less the age of its inputs"
    )
