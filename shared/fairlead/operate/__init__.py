"""A running robot from outside: ask its services, send it a goal, look on, hold a claim.

It is what the command line, a planner or a test does to a robot that runs.
"""
