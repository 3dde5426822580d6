"""Forces: one module each, with its derivation, its parameters and compiled functions of one element.

`law` says what a force is; `loops` makes of it what methods need, written once; `elements` puts it on a net; `table`
has all forces of a net as rows, with those written in Python by the protocol of `force` as callbacks (`python`).
"""
