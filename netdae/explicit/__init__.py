"""The explicit method: a compiled velocity Verlet, its step, its chunks and the kicks between them.

`stepper` flies `chunk` by chunk, with the step length of `stable_step`; `kernel` binds the loop of `verlet` to a
system, whose forces `forces` puts into arrays; those that the loop does not know act by `kicks`.
"""
