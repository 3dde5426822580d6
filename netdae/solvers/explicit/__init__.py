"""The explicit method: a compiled velocity Verlet, its step and its chunks.

`stepper` flies `chunk` by chunk, with the step length of `stable_step`; `kernel` binds the loop of `verlet` to a
system's table of forces. What is taken at the end of a step, whatever its stiffness, is in `drums` and `rayleigh`.
"""
