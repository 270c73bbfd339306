"""The parts of a number as numbers: `real` and `imag`, `value` and `tangent`."""

from __future__ import annotations

from numba.core.imputils import lower_getattr
from numba.core.typing.templates import AttributeTemplate, infer_getattr

from powered_walker_env.compiled.lanes.kinds import (
    Dual,
    DualPlane,
    Lanes,
    Number,
    Plane,
    Zero,
    number_of,
    value_of,
)


def _attribute(kind, name, result, members):
    """A part of a number as a number of another kind: `members` renames its vectors."""

    @lower_getattr(type(kind), name)
    def _part(context, builder, numba_type, value):
        held = number_of(context, builder, numba_type, value)
        part = Number(**{new: getattr(held, old) for new, old in members.items()})
        return value_of(context, builder, result, part)


def _attributes(kind, parts):
    @infer_getattr
    class _Attributes(AttributeTemplate):
        key = type(kind)

        def generic_resolve(self, _, name):
            return parts[name][0] if name in parts else None

    for name, (result, members) in parts.items():
        _attribute(kind, name, result, members)


_REAL, _IMAG = {"real": "real"}, {"real": "imag"}
_attributes(Zero, {"real": (Zero, {}), "imag": (Zero, {})})
_attributes(Plane, {"real": (Lanes, _REAL), "imag": (Lanes, _IMAG)})
_attributes(Dual, {"value": (Lanes, _REAL), "tangent": (Lanes, {"real": "dreal"})})
_attributes(
    DualPlane,
    {
        "real": (Dual, _REAL | {"dreal": "dreal"}),
        "imag": (Dual, _IMAG | {"dreal": "dimag"}),
        "value": (Plane, _REAL | {"imag": "imag"}),
        "tangent": (Plane, {"real": "dreal", "imag": "dimag"}),
    },
)
