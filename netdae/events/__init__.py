"""Events of a flight: what is watched, and what has been found."""
