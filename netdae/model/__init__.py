"""The net and what it is made of: frozen data, without forces."""
