"""Policies that LeRobot trained, run by the interpreter that has LeRobot."""
