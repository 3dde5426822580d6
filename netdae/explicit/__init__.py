"""The explicit method: a compiled velocity Verlet, its step, its chunks and the kicks between them."""
