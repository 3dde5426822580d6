"""The verification cases, one module each; a module has a `CASE`, and its docstring derives the reference."""
