"""docs/records.md says what the tests of the two records say, without gaps."""

from tests.records.page import PAGE, current_page


def test_the_page_of_the_records_is_made_of_their_tests() -> None:
    assert PAGE.read_text() == current_page(), "write it: python -m tests.records --write"
