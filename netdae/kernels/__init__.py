"""Forces as flat arrays and compiled loops, for the methods that fly without Python: node i at 3i.

The formulas are those of the package `forces`. `explicit` flies with `cables`, `cordage` (cords through rings),
`reels`, `loads` and `rayleigh`, which takes damping implicitly; `ida` with `cables`, `strings` (cords through rings,
and motors) and `surfaces`, and with the arrays of `reels`.
"""
