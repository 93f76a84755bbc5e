"""Program that solves linear systems with PETSc, for another process.

It runs under any Python that has petsc4py, and imports nothing else but numpy. Arrays are files of
raw numbers in a folder: starts, columns (int32) of the rows of a matrix, values, right, solution
(float64). Commands come as lines, each is answered by a line; it ends with its input.

    matrix    the values have changed
    solve     solution = A^-1 right; answers "ok" and the iterations, or "failed" and why
"""

import os
import sys

sys.path.pop(0)  # its own folder, whose names are not meant for others

import numpy as np

SURPLUS = 15  # iterations beyond those of a fresh hierarchy that a new one is worth
HYPRE = {
    "strong_threshold": 0.7,
    "coarsen_type": "HMIS",
    "interp_type": "ext+i",
    "P_max": 4,
    "agg_nl": 1,
}


class Server:
    """A matrix in the files of a folder and its solver."""

    def __init__(self, folder, reduction, iterations):
        from petsc4py import PETSc

        if np.dtype(PETSc.ScalarType) != np.float64 or np.dtype(PETSc.IntType) != np.int32:
            raise TypeError("PETSc must have real numbers of 64 bits and integers of 32 bits")
        starts, columns = (mapped(folder, name, np.int32) for name in ("starts", "columns"))
        self.arrays = starts, columns, mapped(folder, "values", np.float64)
        n = len(starts) - 1
        self.A = PETSc.Mat().createAIJWithArrays((n, n), self.arrays, comm=PETSc.COMM_SELF)
        self.right = PETSc.Vec().createWithArray(
            mapped(folder, "right", np.float64), comm=PETSc.COMM_SELF
        )
        self.solution = PETSc.Vec().createWithArray(
            mapped(folder, "solution", np.float64, "r+"), comm=PETSc.COMM_SELF
        )
        self.solver = solver(PETSc, reduction, iterations)
        self.fresh, self.least, self.surplus = True, 0, 0

    def matrix(self):
        self.A.stateIncrease()
        self.A.assemble()
        self.solver.setOperators(self.A)
        if self.surplus > SURPLUS:
            self.fresh = True
        return "ok"

    def solve(self):
        """By the hierarchy at hand, then by a new one."""
        for fresh in (self.fresh, True):
            self.fresh = self.fresh or fresh
            if self.tried():
                return f"ok {self.solver.getIterationNumber()}"
        return f"failed it did not converge (reason {self.solver.getConvergedReason()})"

    def tried(self):
        self.solver.getPC().setReusePreconditioner(not self.fresh)
        self.solver.setOperators(self.A)
        self.solver.solve(self.right, self.solution)
        taken = self.solver.getIterationNumber()
        if self.fresh:
            self.least, self.surplus = taken, 0
        self.least = min(self.least, taken)
        self.surplus += taken - self.least
        self.fresh = False
        return self.solver.getConvergedReason() > 0


def mapped(folder, name, kind, mode="c"):
    return np.memmap(os.path.join(folder, name), dtype=kind, mode=mode)


def solver(PETSc, reduction, iterations):
    """GMRES, preconditioned by the multigrid of hypre where PETSc has it, else by its own."""
    ksp = PETSc.KSP().create(PETSc.COMM_SELF)
    ksp.setType("gmres")
    ksp.setGMRESRestart(iterations)
    ksp.setTolerances(rtol=reduction, atol=0.0, divtol=1e30, max_it=iterations)
    options = PETSc.Options()
    if PETSc.Sys.hasExternalPackage("hypre"):
        ksp.getPC().setType("hypre")
        ksp.getPC().setHYPREType("boomeramg")
        # light for hexahedra: De Sterck, Yang & Heys (2006)
        for name, value in HYPRE.items():
            options[f"pc_hypre_boomeramg_{name}"] = value
    else:
        ksp.getPC().setType("gamg")
    ksp.setFromOptions()
    return ksp


def answer(server, command):
    try:
        return getattr(server, command)()
    except Exception as error:
        return "failed " + " ".join(str(error).split())


def main(folder, reduction, iterations):
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what libraries print is not an answer
    server = Server(folder, float(reduction), int(iterations))
    print("ready", file=answers, flush=True)
    for command in iter(sys.stdin.readline, ""):
        print(answer(server, command.strip()), file=answers, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
