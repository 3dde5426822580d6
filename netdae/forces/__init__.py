"""Forces: one module each, with its derivation, its parameters and compiled functions of one element.

`law` defines a force; `loops` builds from it what the methods need, written once; `elements` applies it to a net;
`table` has all forces of a net as rows; those written in Python to the protocol of `force` are callbacks (`python`).
"""
