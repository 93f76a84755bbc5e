"""Products of rows of a matrix, in vector registers: what solutions and updates consist of.

A compiler that meets the same loops in Python must suspect results of overlapping with factors,
and rows are too short to make up for the tests. Here sums stay in registers until they are done.
Whole vectors are read and written, hence up to ``BEYOND`` numbers behind the last one of a row:
there must be as many, what is written there means nothing.
"""

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from mechanics.lanes import WIDTH

BEYOND = WIDTH - 1
"""Numbers behind a row that are touched."""
ROWS = 4
"""Rows whose products are made at once."""
_WHOLE, _LANE = ir.IntType(64), ir.IntType(32)
_KIND = ir.VectorType(ir.DoubleType(), WIDTH)
_NONE = ir.Constant(_KIND, [0.0] * WIDTH)
_FUSED = ("contract",)


def _data(context: Any, builder: Any, kind: Any, line: Any) -> Any:
    """Address of the first number of an array."""
    return context.make_array(kind)(context, builder, line).data


def _same(builder: Any, value: Any) -> Any:
    """A number in all lanes."""
    nothing, zeros = ir.Constant(_KIND, ir.Undefined), ir.VectorType(_LANE, WIDTH)
    one = builder.insert_element(nothing, value, _LANE(0))
    return builder.shuffle_vector(one, nothing, ir.Constant(zeros, [0] * WIDTH))


def _load(builder: Any, line: Any, at: Any) -> Any:
    place = builder.bitcast(builder.gep(line, [at]), _KIND.as_pointer())
    return builder.load(place, align=8)


def _store(builder: Any, value: Any, line: Any, at: Any) -> None:
    place = builder.bitcast(builder.gep(line, [at]), _KIND.as_pointer())
    builder.store(value, place, align=8)


def _vectors(builder: Any, count: Any) -> Any:
    """How many vectors hold ``count`` numbers."""
    more = builder.add(count, _WHOLE(BEYOND))
    return builder.ashr(more, _WHOLE(WIDTH.bit_length() - 1))


def _combined(results: int) -> Any:
    """Lowering of ``combine`` and ``combine_two``."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kinds, (stride, n, count) = sig.args[:-3], args[-3:]
        lines = [_data(context, builder, *pair) for pair in zip(kinds, args, strict=False)]
        outs, factors, rows = lines[:results], lines[results:-1], lines[-1]
        sums = [cgutils.alloca_once(builder, _KIND) for _ in outs]
        with cgutils.for_range(builder, _vectors(builder, n)) as part:
            at = builder.mul(part.index, _WHOLE(WIDTH))
            for total in sums:
                builder.store(_NONE, total)
            with cgutils.for_range(builder, count) as row:
                place = builder.add(builder.mul(row.index, stride), at)
                values = _load(builder, rows, place)
                for total, line in zip(sums, factors, strict=True):
                    factor = _same(builder, builder.load(builder.gep(line, [row.index])))
                    product = builder.fmul(factor, values, flags=_FUSED)
                    less = builder.fsub(builder.load(total), product, flags=_FUSED)
                    builder.store(less, total)
            for total, out in zip(sums, outs, strict=True):
                _store(builder, builder.load(total), out, at)
        return context.get_dummy_value()

    return generate


def _combine(typing_context, out, factors, rows, stride, n, count):
    """out[:n] = -sum over j < count of factors[j] rows[j stride:]."""
    whole = types.int64
    return types.void(out, factors, rows, whole, whole, whole), _combined(1)


def _combine_two(typing_context, out, other, factors, second, rows, stride, n, count):
    """The same for two results of the same rows, which are fetched once for both."""
    whole = types.int64
    return types.void(out, other, factors, second, rows, whole, whole, whole), _combined(2)


def _dots(typing_context, rows, stride, values, n, out):
    """out[:ROWS] = products of rows, ``stride`` apart, with n values, which zeros follow."""

    def generate(context, builder, sig, args):
        lines = [_data(context, builder, sig.args[k], args[k]) for k in (0, 2, 4)]
        stride, n = args[1], args[3]
        sums = [cgutils.alloca_once(builder, _KIND) for _ in range(ROWS)]
        for total in sums:
            builder.store(_NONE, total)
        with cgutils.for_range(builder, _vectors(builder, n)) as part:
            at = builder.mul(part.index, _WHOLE(WIDTH))
            x = _load(builder, lines[1], at)
            for k, total in enumerate(sums):
                place = builder.add(at, builder.mul(stride, _WHOLE(k)))
                product = builder.fmul(_load(builder, lines[0], place), x, flags=_FUSED)
                builder.store(builder.fadd(builder.load(total), product, flags=_FUSED), total)
        for k, total in enumerate(sums):
            builder.store(_added_up(builder, total), builder.gep(lines[2], [_WHOLE(k)]))
        return context.get_dummy_value()

    whole = types.int64
    return types.void(rows, whole, values, whole, out), generate


def _added_up(builder: Any, total: Any) -> Any:
    """Sum of the lanes, by halves."""
    vector, width = builder.load(total), WIDTH
    while width > 1:
        width //= 2
        kind = ir.VectorType(_LANE, width)
        low, high = (
            builder.shuffle_vector(vector, vector, ir.Constant(kind, list(range(a, a + width))))
            for a in (0, width)
        )
        vector = builder.fadd(low, high)
    return builder.extract_element(vector, _LANE(0))


# what intrinsics are called with is not what they are defined with
combine: Any = intrinsic(_combine)
combine_two: Any = intrinsic(_combine_two)
dots: Any = intrinsic(_dots)
