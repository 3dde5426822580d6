"""SUNDIALS IDA: driven from Python, and by compiled callbacks hung into the library of scikit-sundae's wheel.

From Python: `stepper`, by scikit-sundae. Compiled, many steps at a time:

- `native`, the stepper that takes it where it can; `chunk`, its loop of steps, with the `books` of each;
- `sundials`, the C library; `memory`, IDA's own objects; `calls`, the functions that it calls;
- `kernel` and `matrix`, residual and Newton matrix of cables, damping and loads;
- `record`, all that these work on; `layout`, how compiled code sees it; `addressed` and `addresses` of its arrays;
- `further`, `further_record`, `further_functions`, `further_calls`: the same for all else that ships, which is `reels`
  and cords through rings (`links`, `dyads`), and `outside` forces; `lines` tells what is linear in time;
- `asked` and `asking`, for what compiled code cannot know: forces and motions of a user's own.

`failures` has the words for a flight that cannot go on, of both.
"""
