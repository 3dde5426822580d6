"""The driver of flights, the integration methods, and nets at rest."""
