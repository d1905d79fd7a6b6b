"""Proof that deployed episodes do what the same vectors do in plain robosuite.

Episodes run through the processes, then the policy's raw vectors through a loop of ``env.step`` in
a process that knows nothing of the HAL; what the policy saw and said is computed again in this one.
Everything is compared bit for bit.
"""
