"""The Gymnasium environment: one step is one stride."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from powered_walker_env.envs.disturbances import Disturbance
from powered_walker_env.envs.setup import make_task
from powered_walker_env.envs.task import OBSERVATION_LIMIT, Task
from powered_walker_env.envs.walkers import Walkers
from powered_walker_env.model.powering import AnyControl, Scheme
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation.strides import Array

if TYPE_CHECKING:
    from powered_walker_env.envs.show import StrideShow

Observation = NDArray[np.float32]
Action = NDArray[np.float32]
RENDER_FPS = 25
STRIDE_RTOL = 1e-8
RESET_OPTIONS = ("state",)


def observation_space() -> gym.Space[Observation]:
    """Deviations from the gait, finite bounds."""
    space: Any = gym.spaces.Box(-OBSERVATION_LIMIT, OBSERVATION_LIMIT, (4,), np.float32)
    return space


def action_space(powered: Scheme) -> gym.Space[Action]:
    """One for each number of the control, as switch angle and stall torque; 0: the open loop."""
    space: Any = gym.spaces.Box(-1.0, 1.0, (len(powered.numbers),), np.float32)
    return space


class PoweredWalkerEnv(gym.Env[Observation, Action]):
    """
    ## Description

    A planar walker with two straight legs hinged at the hip and massless round feet
    (J. Camp, *Powered "Passive" Dynamic Walking*, Cornell University, 1997). After each
    heel strike its feet are locked and it swings passively; when the hip angle falls to
    the switch angle, a DC motor at constant voltage starts to extend the stance foot,
    until the next heel strike. **One step of the environment is one stride**, decided
    just after heel strike. The open-loop motor (a constant action of zero) walks on a
    limit cycle that is stable but whose basin is narrow: small pushes make it fall after
    a dozen strides. The task is to keep walking, close to the gait.

    | Id                            | Walker                          | Physics       |
    |-------------------------------|---------------------------------|---------------|
    | `PoweredWalker-v0`            | the thesis's, point feet        | the text's    |
    | `PoweredWalkerRoundFoot-v0`   | the thesis's masses, round feet | the text's    |
    | `PoweredWalkerAsPublished-v0` | the thesis's, point feet        | the listing's |

    ## Action Space

    `Box(-1, 1, (2,), float32)`; actions outside are clipped.

    | Num | Action             | At −1              | At 0    | At +1              |
    |-----|--------------------|--------------------|---------|--------------------|
    | 0   | switch angle (rad) | nominal − range    | nominal | nominal + range    |
    | 1   | stall torque (N m) | nominal·(1 − frac) | nominal | nominal·(1 + frac) |

    | Walker       | Nominal switch angle and stall torque | Range    | Frac |
    |--------------|---------------------------------------|----------|------|
    | the thesis's | 2.9068 rad, 729.8 N m                 | 0.15 rad | 3 %  |
    | as published | 2.8625 rad, 692 N m                   | 0.15 rad | 3 %  |
    | round feet   | 2.704 rad, 3371.8 N m                 | 0.2 rad  | 30 % |

    `env.unwrapped.control(action)` gives the control that an action means.

    Another `scheme` has another control, and one action for each of its k numbers,
    `Box(-1, 1, (k,), float32)`, in this order. By default ±1 is ±0.15 rad of an angle and
    ±30 % of the absolute value of a strength.

    | Scheme                                         | Control                           |
    |------------------------------------------------|-----------------------------------|
    | `motor`, `motor-with-stop`                     | switch angle, stall torque (N m)  |
    | `toe-off`, `toe-off-at-strike`, `late-toe-off` | impulse (N s)                     |
    | `hip-torque`                                   | switch angle, hip torque (N m)    |

    ## Observation Space

    `Box(-20, 20, (4,), float32)`: the post-strike state minus the nominal gait's, over
    the scales below, clipped.

    | Num | Observation                   | Scale                 | Min | Max |
    |-----|-------------------------------|-----------------------|-----|-----|
    | 0   | stance angle α (ankle to hip) | 0.05 rad              | −20 | 20  |
    | 1   | swing angle s (ankle to hip)  | 0.05 rad              | −20 | 20  |
    | 2   | stance rate α'                | 0.15 rad/s · √(g/10L) | −20 | 20  |
    | 3   | swing rate β'                 | 0.3 rad/s · √(g/10L)  | −20 | 20  |

    Angles are from the floor's normal, forward positive. √(g/10L), SI, is 1 for the
    registered walkers. A gait of several strides counts from its first. After a fall there
    is no post-strike state: the observation is that of the last one.

    ## Rewards

    The sum of three terms, all in `info`: `reward_stability`, `reward_effort`,
    `reward_fall`. With d the distance of the post-strike state from the gait (the
    nearest point of its cycle) in units of the scales above:

    - `reward="deviation"` (default): exp(−d²/2) after the stride; 0 on a fall.
    - `reward="contraction"`: log((d + ε)/(d' + ε)), d before and d' after the stride and
      ε = 0.01. The sum telescopes: the return is the measured stability. −10 on a fall.
    - `reward="periodicity"`: exp(−d²/2) with d the distance between successive
      post-strike states: no target gait needed; 0 on a fall.

    `reward_effort` is −`effort_weight` times the stride's mechanical cost of transport
    (positive work over weight times step length); 0 by default, and on a fall.

    `info` has the same keys at every step and at reset: `state` (the true post-strike
    state α, s, α', β', rad and rad/s, without sensor noise; the last one after a fall),
    `control` (its numbers, SI units, torque noise included), `outcome` (an int, see
    `powered_walker_env.Outcome`), `duration` (s), `step_length` and `step_height` (m),
    `energy_in`, `positive_work` and `energy_lost` (J, by what powers it and at heel
    strike), `distance` (d after the stride), and the terms of the reward. Schemes other
    than the motor's have each number of the control by its name, too (`impulse`).

    ## Starting State

    On the nominal gait, just after a heel strike and its push (see Disturbances).
    `reset(options={"state": (α, s, α', β')})` starts exactly there.

    ## Episode End

    Termination: the walker falls; `info["outcome"]` says how.
    Truncation: after 100 strides (the registered `max_episode_steps`).

    ## Arguments

    ```python
    gym.make("powered_walker_env:PoweredWalker-v0", reward="contraction", disturbance="rough")
    ```

    | Argument        | Default       | Meaning                                         |
    |-----------------|---------------|-------------------------------------------------|
    | `preset`        | `"camp1997"`  | a powered one of `PRESETS`; the ids set it      |
    | `params`        | `None`        | with `preset=None`: `WalkerParams`, or a dict   |
    | `scheme`        | `None`        | what powers it, by name; the preset's, `motor`  |
    | `control`       | `None`        | nominal: the scheme's numbers, or an object     |
    | `gait`          | `None`        | its post-strike state, or those of its cycle    |
    | `action_range`  | `None`        | what action 1 adds: rad, fraction of a strength |
    | `reward`        | `"deviation"` | or `"contraction"`, `"periodicity"`             |
    | `effort_weight` | `0.0`         | reward lost per unit of cost of transport       |
    | `disturbance`   | `"light"`     | a level, or standard deviations by kind         |
    | `render_mode`   | `None`        | `"human"`, `"rgb_array"` or `"rgb_array_list"`  |

    Control and gait that are left out are those of the preset, whose scheme cannot be
    changed: `scheme` chooses the first preset that has it if neither `preset` nor `params`
    is given. With `params` it says whose numbers `control` holds. A walker given by `params`,
    or a preset under another control, needs a gait: given, it is taken as it is; left out,
    it is searched, with `GaitNotFoundError` if there is none.

    `"rgb_array_list"` gives every picture since the last `render()` or `reset()`, at
    `render_fps` (25 per second of the walk), for `gymnasium.utils.save_video`, say.
    `RecordVideo` keeps the last picture of each stride only.

    ### Disturbances

    `"none"`, `"light"` or `"rough"` pushes; a level of another kind, as in
    `"light-ground"`; or a dict of standard deviations, as in
    `{"push": 0.01, "torque": 0.02}`. All draws are normal. Under a level of any kind the
    open loop falls about as soon as under the pushes (see `envs/disturbances.py`).

    | Kind         | Unit, and when it is drawn        | Thesis's, light / rough |
    |--------------|-----------------------------------|-------------------------|
    | `push`       | rad/s, both leg rates, per stride | 0.005 / 0.01            |
    | `ground`     | leg lengths, height per landing   | 0.00019 / 0.00061       |
    | `slope`      | rad, per episode                  | 0.0039 / 0.01           |
    | `torque`     | fraction of strength, per stride  | 0.005 / 0.02            |
    | `sensor`     | observation units, per stride     | 0.026 / 0.053           |
    | `parameters` | fraction of each ¹, per episode   | 0.015 / 0.064           |

    | Kind         | As published, light / rough | Round feet, light / rough |
    |--------------|-----------------------------|---------------------------|
    | `push`       | 0.02 / 0.04                 | 0.02 / 0.05               |
    | `ground`     | 0.0022 / 0.0061             | 0.0031 / 0.021            |
    | `slope`      | 0.0089 / 0.025              | 0.039 / 0.081             |
    | `torque`     | 0.11 / 0.17                 | 0.046 / 0.2               |
    | `sensor`     | 0.11 / 0.21                 | 0.11 / 0.26               |
    | `parameters` | 0.12 / 0.2                  | 0.13 / 0.27               |

    ¹ foot length, leg mass, leg inertia and no-load speed of the motor, log-normal. Other
    walkers take the thesis's levels, the push in proportion to √(g/L), but for the presets
    `toe-off` and `hip-torque`, which have their own (see `envs/disturbances.py`).

    ## Version History

    - v0: first release.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 (Gymnasium declares it so)
        "render_modes": ["human", "rgb_array", "rgb_array_list"],
        "render_fps": RENDER_FPS,
    }

    def __init__(
        self,
        preset: str | None = None,
        params: WalkerParams | Mapping[str, Any] | None = None,
        control: AnyControl | Sequence[float] | None = None,
        gait: Sequence[Any] | None = None,
        action_range: Sequence[float] | None = None,
        reward: str = "deviation",
        effort_weight: float = 0.0,
        disturbance: str | Mapping[str, float] | Disturbance = "light",
        render_mode: str | None = None,
        scheme: str | None = None,
    ) -> None:
        """See the class.

        Raises:
            ValueError: an argument out of its domain, or two that contradict.
            GaitNotFoundError: parameters without a gait, and none found.
        """
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ValueError(
                f"render_mode must be one of {self.metadata['render_modes']}, got {render_mode!r}"
            )
        self.task: Task = make_task(
            preset, params, scheme, control, gait, action_range, reward, effort_weight, disturbance
        )
        self.render_mode = render_mode
        self.observation_space = observation_space()
        self.action_space = action_space(self.task.scheme)
        self._walkers = Walkers(self.task, 1, STRIDE_RTOL)
        self._seeded = False
        self._walking = False  # from a reset to a fall
        self._show: StrideShow | None = None

    def control(self, action: Sequence[float] | Action) -> AnyControl:
        """The control that an action means: the public action mapping (without noise).

        Raises:
            ValueError: an action that is not k finite numbers.
        """
        scheme = self.task.scheme
        wanted = np.clip(check_action(action, self.action_space.shape, scheme), -1.0, 1.0)
        meant: AnyControl = scheme.of_numbers(self.task.nominal + wanted * self.task.half_range)
        return meant

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; `options={"state": ...}` starts at a post-strike state.

        The seed decides where the walker's random numbers begin; without one they go on.

        Raises:
            ValueError: an unknown option, or a state that is not four finite numbers.
        """
        state = check_options(options)
        super().reset(seed=seed)
        if seed is not None or not self._seeded:
            self._walkers.seed(0, self.np_random)
            self._seeded = True
        self._walkers.reset(state=state)
        self._walking = True
        if self.render_mode is not None:
            self._stage().begin()
        return self._walkers.observations[0].copy(), first_of(self._walkers.start_info())

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Walk one stride.

        Raises:
            ValueError: an action that is not k finite numbers.
            gymnasium.error.ResetNeeded: before the first reset, or after a fall.
        """
        if not self._walking:
            raise gym.error.ResetNeeded(
                "call reset(): no walk has begun yet, or it ended in a fall"
            )
        wanted = check_action(action, self.action_space.shape, self.task.scheme)
        start = PostStrikeState(*self._walkers.states[0].tolist())
        result = self._walkers.step(wanted[np.newaxis])
        self._walking = not result.terminated[0]
        if self.render_mode is not None:
            self._stage().add(start)
        return (
            result.observation[0],
            float(result.reward[0]),
            not self._walking,
            False,
            first_of(result.info),
        )

    def get_state(self) -> dict[str, Any]:
        """Everything the future depends on, random numbers included; for planners.

        JSON-able. The wrappers of `gym.make` keep their own: `TimeLimit` its count.
        """
        return {**self._walkers.get_state(0), "walking": self._walking, "seeded": self._seeded}

    def set_state(self, saved: dict[str, Any]) -> None:
        """Go back to a state of `get_state` (of an environment with the same arguments)."""
        self._walkers.set_state(0, saved)
        self._walking, self._seeded = saved["walking"], saved["seeded"]
        if self.render_mode is not None and self._walking:
            self._stage().begin()

    def render(self) -> Any:
        """The last picture; with `"rgb_array_list"` all since the last call.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        if self.render_mode is None:
            gym.logger.warn(
                "render() was called without a render mode; pass one to gym.make, for "
                'example render_mode="rgb_array"'
            )
            return None
        if self._show is None:
            raise gym.error.ResetNeeded("call reset() before render()")
        return self._show.picture()

    def close(self) -> None:
        """Close the window, if any."""
        if self._show is not None:
            self._show.close()
            self._show = None

    def _stage(self) -> StrideShow:
        if self._show is None:
            from powered_walker_env.envs.show import StrideShow

            self._show = StrideShow(self._walkers, str(self.render_mode), RENDER_FPS)
        return self._show


def check_options(options: dict[str, Any] | None) -> PostStrikeState | None:
    """The start that reset options ask for.

    Raises:
        ValueError: an option that does not exist, or a state that is not four numbers.
    """
    unknown = [name for name in options or {} if name not in RESET_OPTIONS]
    if unknown:
        raise ValueError(f"reset options are {', '.join(RESET_OPTIONS)}, got {unknown[0]!r}")
    state = (options or {}).get("state")
    return None if state is None else check_state(state)


def check_action(action: Any, shape: tuple[int, ...] | None, powered: Scheme) -> Array:
    """The action as float64.

    Raises:
        ValueError: another shape, or a number that is not finite.
    """
    try:
        wanted = np.asarray(action, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"action must be numbers of shape {shape}, got {action!r}") from None
    if wanted.shape != shape:
        numbers = ", ".join(name.replace("_", " ") for name in powered.numbers)
        raise ValueError(
            f"action must have shape {shape}, ({numbers}) for each walker, got {wanted.shape}"
        )
    if not np.isfinite(wanted).all():
        raise ValueError(f"action must be finite, got {wanted[~np.isfinite(wanted)][0]}")
    return wanted


def first_of(info: dict[str, NDArray[Any]]) -> dict[str, Any]:
    """The info of one walker from that of a batch of one: numbers as plain Python."""
    return {name: values[0] if values.ndim > 1 else values.item() for name, values in info.items()}
