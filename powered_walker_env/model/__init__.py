"""What walks.

- `walker`, `state`: its parameters, and its state after heel strike; `quantities`: what their
  numbers are;
- `phases`: a stride as a list of phases (read this first); `powering`: the ways to power it;
- `mechanics`: a chain of links, its torques, guards and impacts;
- `presets`: walkers with known gaits; `rimless_wheel`: the wheel in closed form.
"""

from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.presets import PRESETS, Preset, preset
from powered_walker_env.model.quantities import Quantity, quantities
from powered_walker_env.model.rimless_wheel import RimlessWheel
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams

__all__ = [
    "PRESETS",
    "Outcome",
    "PostStrikeState",
    "Preset",
    "Quantity",
    "RimlessWheel",
    "WalkerParams",
    "preset",
    "quantities",
]
