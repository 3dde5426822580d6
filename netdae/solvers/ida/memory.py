"""IDA's own objects for one system: its memory and vectors, with solvers that are compiled callbacks."""

from __future__ import annotations

import ctypes as c
import math

from netdae.core.arrays import FloatArray
from netdae.solvers.ida.calls import (
    keep_nothing,
    keep_setup,
    keep_test,
    on_jacobian,
    on_linear_setup,
    on_newton,
    on_norm,
    on_residual,
    on_weights,
    report_iteration,
)
from netdae.solvers.ida.layout import RECORD
from netdae.solvers.ida.record import IdaRecord
from netdae.solvers.ida.sundials import Sundials, put, word
from netdae.solvers.ida.taut import LOW_ORDER
from netdae.solvers.options import HIGHEST_ORDER, SolverOptions

# The step is kept unless it would grow to at least twice or shrink to 0.7 or less, so that c_j and with it the factor
# stay. A change of c_j by more than a tenth makes a new factor; Newton's corrections may end at 0.6 of the error norm.
# Measured on the reference flight of 21 x 21 knots against IDA's own settings: 16 % fewer residuals, 2.7 times fewer
# Newton failures and half the loss of energy, for 25 % more factors of the few taut cables.
KEPT_STEPS = (0.7, 2.0)
KEPT_CJ = 0.1
KEPT_CJ_WHOLE = 0.4  # with Rayleigh damping, whose factor is ten times as expensive
NEWTON_TOLERANCE = 0.6

_ERRORS_FAILED = RECORD.fields["errors_failed"][1]  # type: ignore[index]
_NEWTON = {
    "Solve": on_newton,
    "SetSysFn": keep_nothing,
    "SetLSetupFn": keep_setup,
    "SetLSolveFn": keep_nothing,
    "SetConvTestFn": keep_test,
    "SetMaxIters": keep_nothing,
    "GetCurIter": report_iteration,
}


class IdaMemory:
    """IDA on a record; raises Unavailable where SUNDIALS is not as expected."""

    def __init__(self, library: Sundials, record: IdaRecord, options: SolverOptions) -> None:
        self._library = library
        self._record = record
        self._address = address = record.address
        y, yp, z = record.chunk.states[0], record.chunk.slopes[0], record.chunk.z
        self._data = y.ctypes.data, yp.ctypes.data
        call = library.call
        self._context = library.context()
        self._y, self._yp, self._z = (library.vector(each, self._context) for each in (y, yp, z))
        for vector in (self._y, self._yp, self._z):
            library.put_operation(vector, "N_VWrmsNorm_Serial", on_norm.address)
        self._matrix = call("SUNDenseMatrix", 1, 1, self._context)  # a direct solver must have one
        self._linear = call("SUNLinSolNewEmpty", self._context)
        library.put_operation(self._linear, "SUNLinSolGetType_Dense")
        library.put_operation(self._linear, "SUNLinSolSetup_Dense", on_linear_setup.address)
        library.put_operation(self._linear, "SUNLinSolSolve_Dense")  # is not called
        self._newton = call("SUNNonlinSolNewEmpty", self._context)
        put(self._newton, 0, address)
        library.put_operation(self._newton, "SUNNonlinSolGetType_Newton")
        for name, function in _NEWTON.items():
            library.put_operation(self._newton, f"SUNNonlinSol{name}_Newton", function.address)
        self._ida = call("IDACreate", self._context)
        call("IDAInit", self._ida, on_residual.address, 0.0, self._y, self._yp)
        call("IDAWFtolerances", self._ida, on_weights.address)
        call("IDASetUserData", self._ida, address)
        call("IDASetNonlinearSolver", self._ida, self._newton)
        call("IDASetLinearSolver", self._ida, self._linear, self._matrix)
        call("IDASetJacFn", self._ida, on_jacobian.address)
        call("IDASetMaxOrd", self._ida, options.max_order or HIGHEST_ORDER)
        if options.max_step is not None:
            call("IDASetMaxStep", self._ida, options.max_step)
        call("IDASetNonlinConvCoef", self._ida, NEWTON_TOLERANCE)
        call("IDASetDeltaCjLSetup", self._ida, KEPT_CJ_WHOLE if record.whole else KEPT_CJ)
        call("IDASetEtaFixedStepBounds", self._ida, *KEPT_STEPS)
        record.set(
            memory=self._ida,
            y=self._y,
            yp=self._yp,
            correction=self._z,
            ida_solve=library.address_of("IDASolve"),
            system_data=library.address_of("IDAGetNonlinearSystemData"),
            error_test_fails=library.address_of("IDAGetNumErrTestFails"),
            get_order=library.address_of("IDAGetCurrentOrder"),
            set_highest_order=library.address_of("IDASetMaxOrd"),
            start_anew=library.address_of("IDAReInit"),
            highest=options.max_order or HIGHEST_ORDER,
        )

    def start(self, t: float, taut: bool) -> None:
        """Start afresh at t from the record's first states and slopes; the record counts failures from now on.

        taut : whether a cable pulls: then the order stays low until the steps show how long they will be
        """
        put(word(self._y), 1, self._data[0])
        put(word(self._yp), 1, self._data[1])
        self._library.call("IDAReInit", self._ida, t, self._y, self._yp)
        self._library.call("IDAGetNumErrTestFails", self._ida, self._address + _ERRORS_FAILED)
        allowed = self._record["highest"]
        if taut:
            allowed = min(allowed, LOW_ORDER)
        self._library.call("IDASetMaxOrd", self._ida, allowed)
        self._record.set(allowed=allowed, since=0, above=0, failed_earlier=0, h_before=0.0)

    def bound_step(self, h: float) -> None:
        """Let no step be longer than h s; infinite for no bound."""
        self._library.call("IDASetMaxStep", self._ida, 0.0 if h == math.inf else h)

    def stop_at(self, t: float) -> None:
        """Let no step reach beyond t."""
        self._library.call("IDASetStopTime", self._ida, t)

    def polynomial(self, t: float, y: FloatArray) -> None:
        """IDA's own polynomial in the last step, at t, into y (6n,)."""
        vector = self._library.vector(y, self._context)
        self._library.call("IDAGetDky", self._ida, t, 0, vector)
        self._library.call("N_VDestroy", vector)

    def free(self) -> None:
        """Free all of it."""
        call = self._library.call
        call("IDAFree", c.byref(c.c_void_p(self._ida)))
        call("SUNNonlinSolFreeEmpty", self._newton)
        call("SUNLinSolFreeEmpty", self._linear)
        call("SUNMatDestroy", self._matrix)
        call("N_VDestroy", self._y)
        call("N_VDestroy", self._yp)
        call("N_VDestroy", self._z)
        call("SUNContext_Free", c.byref(c.c_void_p(self._context)))
