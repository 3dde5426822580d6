"""Verification: cases with a known answer, each one file in `cases/`, and how they are flown.

A case is found by being there: a module of `cases/` with a `CASE`. The tests and the report of `netdae verify` fly
the same cases, with the tolerances that stand in them.
"""
