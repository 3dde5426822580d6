"""Rigid shapes of targets and obstacles: their data, signed distances, mass properties and surfaces."""
