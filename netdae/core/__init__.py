"""Foundations of the package: arrays, errors, files, and records that compiled code reads from one address."""
