"""Formulas for several elements at once, in the lanes of the vector registers of a processor.

A formula is a Python function from a list of ``Lanes`` to a list of them. It runs once, when it is
compiled: its loops over tables are unrolled, products by 0 and 1 leave no trace, and nothing that
it holds needs memory which a compiler would have to suspect of changing. Operations stay in the
order in which they are written, so results are those of the same formula for one element.
"""

from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

WIDTH = 8
"""Elements at once: what the widest registers hold."""
_KIND = ir.VectorType(ir.DoubleType(), WIDTH)


class Lanes:
    """A number of each of ``WIDTH`` elements, or one that is the same in all (``number``)."""

    __array_ufunc__ = None
    """Numbers of numpy leave products with them to this class."""

    def __init__(self, builder: Any, value: Any = None, number: float | None = None):
        self._builder, self._value, self.number = builder, value, number

    @property
    def value(self) -> Any:
        """What the compiler knows it by."""
        if self.number is None:
            return self._value
        return ir.Constant(_KIND, [float(self.number)] * WIDTH)

    def _with(self, other: "Lanes | float", operation: str, turned: bool = False) -> "Lanes":
        pair = [self.value, _taken(self._builder, other).value]
        return Lanes(
            self._builder, getattr(self._builder, operation)(*pair[:: -1 if turned else 1])
        )

    def __add__(self, other: "Lanes | float") -> "Lanes":
        known = _taken(self._builder, other)
        if self.number == 0.0 or known.number == 0.0:
            return known if self.number == 0.0 else self
        return self._with(other, "fadd")

    __radd__ = __add__

    def __mul__(self, other: "Lanes | float") -> "Lanes":
        known = _taken(self._builder, other)
        if 0.0 in (self.number, known.number):
            return Lanes(self._builder, number=0.0)
        if self.number == 1.0 or known.number == 1.0:
            return known if self.number == 1.0 else self
        return self._with(other, "fmul")

    __rmul__ = __mul__

    def __sub__(self, other: "Lanes | float") -> "Lanes":
        return self if _taken(self._builder, other).number == 0.0 else self._with(other, "fsub")

    def __rsub__(self, other: float) -> "Lanes":
        return self._with(other, "fsub", turned=True)

    def __neg__(self) -> "Lanes":
        return Lanes(self._builder, self._builder.fneg(self.value))

    def __truediv__(self, other: "Lanes | float") -> "Lanes":
        return self._with(other, "fdiv")

    def __rtruediv__(self, other: float) -> "Lanes":
        return self._with(other, "fdiv", turned=True)

    def root(self) -> "Lanes":
        """Square root."""
        module, kind = self._builder.module, ir.FunctionType(_KIND, [_KIND])
        function = cgutils.get_or_insert_function(module, kind, f"llvm.sqrt.v{WIDTH}f64")
        return Lanes(self._builder, self._builder.call(function, [self.value]))


def _taken(builder: Any, other: Lanes | float) -> Lanes:
    return other if isinstance(other, Lanes) else Lanes(builder, number=float(other))


def compiled(formula: Callable[[list[Lanes]], Sequence[Lanes]], inputs: int) -> Any:
    """``function(source, target)`` for compiled code: rows of ``WIDTH`` numbers, one after another.

    Reads ``inputs`` rows of ``source`` and writes as many of ``target`` as ``formula`` returns.
    """

    @intrinsic
    def function(typing_context, source, target):
        def generate(context, builder, sig, args):
            places = [
                builder.bitcast(context.make_array(kind)(context, builder, line).data,
                                _KIND.as_pointer())
                for kind, line in zip(sig.args, args, strict=True)
            ]  # fmt: skip
            at = ir.IntType(64)
            rows = [
                builder.load(builder.gep(places[0], [at(k)]), align=8) for k in range(inputs)
            ]  # fmt: skip
            found = formula([Lanes(builder, row) for row in rows])
            for k, one in enumerate(found):
                builder.store(one.value, builder.gep(places[1], [at(k)]), align=8)
            return context.get_dummy_value()

        return types.void(source, target), generate

    return function
