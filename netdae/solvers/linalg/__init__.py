"""Factors of sparse matrices, and the condensed Newton system."""
