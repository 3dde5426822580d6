"""SUNDIALS IDA: driven from Python, or by compiled callbacks put into the library of scikit-sundae's wheel.

From Python: `stepper`, by scikit-sundae, with its `iteration` of Newton. Compiled, many steps at a time:

- `native`, the stepper that uses this driver where it can; `trial`, which tests it before it is trusted;
- `chunk`, its loop of steps; `calls`, the functions that the library calls;
- `kernel`, residual and powers; `newton`, the Newton matrix, with the `dyads` of drawcords;
- `sundials`, the C library; `memory`, IDA's own objects;
- `record`, the data that these work on; `layout`, how compiled code sees it.

For both, `taut` has what taut cables without damping ask of a step, and `polish` puts states between steps in balance.

Forces are those of `forces.table`.

`failures` has the error messages of both for a flight that cannot go on.
"""
