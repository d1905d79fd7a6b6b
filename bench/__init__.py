"""Programs a person runs: measurements, campaigns, and the pages and recordings that they write.

``python -m bench.NAME`` starts one; the head of its file says what it does. What they share with
the tests is in `bench.equipment`: a gate, a robot, an episode. Tests run short forms of them; none
of this imports a test.
"""
