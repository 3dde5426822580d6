"""A net with its masses and forces: the equation of motion M ẍ + D ẋ + S(x) x = p(t), and the measurements of it."""
