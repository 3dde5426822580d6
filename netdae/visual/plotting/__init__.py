"""Figures of one or several runs."""
