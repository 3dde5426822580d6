"""SUNDIALS IDA: driven from Python, and by compiled callbacks hung into the library of scikit-sundae's wheel."""
