"""Initial states of a flight: scaled, folded into a canister, ejected."""
