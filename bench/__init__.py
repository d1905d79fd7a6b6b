"""Programs that a person runs: measurements, campaigns, and the pages and days that they write.

``python -m bench.NAME --help`` says what one does. `bench.equipment` is what they share with the
tests: a gate, a robot, an episode. Tests run short forms of them; none of this imports a test.
"""
