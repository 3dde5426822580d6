"""Flights: what drives them, the methods they are flown with, and nets at rest."""
