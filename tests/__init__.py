"""Tests by area, and what only tests use; programs that a person runs are in bench/."""
