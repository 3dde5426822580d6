"""Runs in a folder: from a scenario to its summary, resumed, or as an ensemble."""
