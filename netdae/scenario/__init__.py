"""Scenario files: what they may say, one module per section, and how a simulation is built from it."""
