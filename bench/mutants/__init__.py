"""Mutants of the gate's core: does a test notice when a line of it is wrong?"""
