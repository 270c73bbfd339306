"""How many walkers go abreast: as many as a register of the processor holds doubles.

With more than that a step takes as many times as long, and masks take longer still.
"""

from __future__ import annotations

from llvmlite import binding as llvm
from numba.core.registry import cpu_target

_PROBE = """
define <8 x double> @probe(<8 x double> %x) {
  %y = fadd <8 x double> %x, %x
  ret <8 x double> %y
}
"""
_WIDE = {"zmm": 8, "ymm": 4}  # AVX-512, AVX; others (SSE2, NEON) hold two


def doubles_in_a_register() -> int:
    """What the compiler does with eight doubles, for the processor that numba compiles for.

    That is this machine's, or the one that NUMBA_CPU_NAME and NUMBA_CPU_FEATURES say.
    """
    triple, processor, features = cpu_target.target_context.codegen().magic_tuple()
    machine = llvm.Target.from_triple(triple).create_target_machine(processor, features)
    assembly = machine.emit_assembly(llvm.parse_assembly(_PROBE))
    return next((count for name, count in _WIDE.items() if name in assembly), 2)
