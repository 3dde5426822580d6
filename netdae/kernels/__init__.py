"""Forces as flat arrays and compiled loops, for the methods that fly without Python: node i at 3i."""
