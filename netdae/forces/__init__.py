"""Forces, one small class each, that know their own elements only."""
