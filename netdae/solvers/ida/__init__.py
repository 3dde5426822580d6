"""SUNDIALS IDA: driven from Python, and by compiled callbacks hung into the library of scikit-sundae's wheel.

From Python: `stepper`, by scikit-sundae. Compiled, many steps at a time:

- `native`, the stepper that takes it where it can; `trial`, which tries it before it is trusted;
- `chunk`, its loop of steps; `calls`, the functions that the library calls;
- `kernel`, residual and powers; `newton`, the Newton matrix, with the `dyads` of cords through rings;
- `sundials`, the C library; `memory`, IDA's own objects;
- `record`, all that these work on; `layout`, how compiled code sees it.

Forces are those of `forces.table`.

`failures` has the words for a flight that cannot go on, of both.
"""
