"""The two decisions that fairlead began with, one test for each sentence of them.

One is about the state vector that a policy was trained on, one about the action vector that it
emits. `python -m bench.pages --write` makes README.md here of the tests' names and sentences.
"""
