"""Proof that the deployed services compute what one loop of ``env.step`` computes.

One episode twice, from the same seed: through the processes, and in this process with
the policy's raw vectors. Everything is compared bit for bit.
"""
