"""Pictures, sheets, movies and pages of a run."""
