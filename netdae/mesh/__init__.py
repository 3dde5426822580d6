"""Mesh files: formats, groups, and nets made from them."""
