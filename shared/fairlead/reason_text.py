"""Texts of errors and operators, made fit to be sent: UTF-8, and short."""

from __future__ import annotations

from fairlead.errors import FairleadError

MOST_LETTERS = 500
"""Of a reason: what is longer would make a stop that the gate cannot read."""


def short_text(text: str, most_letters: int = MOST_LETTERS) -> str:
    """The text's beginning; what is no UTF-8 (a file name's bytes, say) is spelled out."""
    return text[:most_letters].encode(errors="backslashreplace").decode()[:most_letters]


def reason_of(error: Exception) -> str:
    """`words_of` an error, as `short_text`."""
    return short_text(words_of(error))


def words_of(error: BaseException) -> str:
    """What an error says, with its type unless it is one of fairlead's own.

    A driver or a policy may raise anything, also what cannot say what it is.
    """
    try:
        said = str(error)
    except Exception as second:  # noqa: BLE001 - see above
        said = f"its text cannot be had: {type(second).__name__}"
    return said if isinstance(error, FairleadError) else f"{type(error).__name__}: {said}"
