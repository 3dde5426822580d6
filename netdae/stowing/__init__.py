"""Nets folded into their canisters."""
