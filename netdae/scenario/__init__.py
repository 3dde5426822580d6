"""Scenario files: what they may say, and how a simulation is built from it."""
