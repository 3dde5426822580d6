"""The explicit method: a compiled velocity Verlet, its step and its chunks.

`stepper` flies in chunks (`chunk`), with the step length of `stable_step`, and `guard` watches its energy; `kernel`
binds the loop of `verlet`, or of `discrete_gradient` for undamped nets, to a system's table of forces, with the data in
`parts`. `active` finds the nodes that have to be moved in each step, `held` drives restrained axes, `wrench` sums
external force and torque. Forces taken at the end of a step, whatever their stiffness, are in `drums` and `rayleigh`.
"""
