"""The documentation of `PoweredWalkerEnv`, its tables made from what they are about."""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Iterable, Sequence

from powered_walker_env.envs.arguments import TaskArguments
from powered_walker_env.envs.disturbances import KINDS, SPREAD_FIELDS, Disturbance
from powered_walker_env.envs.levels import KEY_PUSHES, LEVELS, SIZES
from powered_walker_env.envs.registration import ENVIRONMENTS
from powered_walker_env.envs.rewards import REWARDS
from powered_walker_env.envs.setup import ANGLE_RANGE, STRENGTH_RANGE, default_range
from powered_walker_env.envs.task import STRIDE_INFO
from powered_walker_env.model.powering import SCHEMES, scheme_of
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.quantities import quantities

TEXT = """
    ## Description

    A planar walker with two legs hinged at the hip, straight or with knees, and massless round
    feet (J. Camp, *Powered "Passive" Dynamic Walking*, Cornell University, 1997). After each
    heel strike its feet are locked and it swings passively; when the hip angle falls to the
    switch angle, a DC motor at constant voltage starts to extend the stance foot, until the
    next heel strike. **One step of the environment is one stride**, decided just after heel
    strike. The open-loop motor (a constant action of zero) walks on a limit cycle that is
    stable but whose basin is narrow: small pushes make it fall after a dozen strides. The task
    is to keep walking, close to the gait.

{ids}

    `kneed` has thighs and shanks. Its stance knee is locked; its swing knee is free from heel
    strike until the shank catches up with the thigh (knee strike), then locked, so that
    states, actions and observations are those of straight legs. More falls than theirs end its
    episodes: `LANDED_ON_BENT_KNEE`; `MOTOR_BEFORE_KNEE_STRIKE`, since the motor works on a
    straight-legged walker (on the gait from 0.25 rad above the nominal switch angle, outside
    the default range); `KNEE_STAYED_STRAIGHT`, `NO_KNEE_STRIKE` and `KNEE_FOLDED`. Most of its
    falls are `NO_SWITCH` all the same: its motor starts so shortly before heel strike that a
    pushed walker may land first, and so does the gait at a switch angle 0.06 rad lower.

    ## Action Space

    `Box(-1, 1, (k,), float32)`, one for each of the k numbers of the control, in its order;
    0 is the nominal control, the open loop; actions outside are clipped. ±1 is ± a range,
    rad of an angle, or ± a fraction of the absolute value of a strength (`action_range`).
    `env.unwrapped.control(action)` gives the control that an action means. The motor has
    the two of the first row:

{schemes}

{ranges}

    Other walkers: ±{angle} rad and ±{strength:.0%}.

    ## Observation Space

    `Box(-20, 20, (4,), float32)`: the post-strike state minus the nominal gait's, over
    the scales below, with the sensor's noise, clipped last.

    | Num | Observation                   | Scale                 | Min | Max |
    |-----|-------------------------------|-----------------------|-----|-----|
    | 0   | stance angle α (ankle to hip) | 0.05 rad              | −20 | 20  |
    | 1   | swing angle s (ankle to hip)  | 0.05 rad              | −20 | 20  |
    | 2   | stance rate α'                | 0.15 rad/s · √(g/10L) | −20 | 20  |
    | 3   | swing rate β'                 | 0.3 rad/s · √(g/10L)  | −20 | 20  |

    Angles are from the floor's normal, forward positive. √(g/10L), SI, is 1 for the registered
    walkers (0.99 for `kneed`). A gait of several strides counts from its first. After a fall
    there is no post-strike state: the observation is that of the last one.

    ## Rewards

    The sum of three terms, all in `info`: `reward_stability`, `reward_effort`,
    `reward_fall`. With d the distance of the post-strike state from the gait (the
    nearest point of its cycle) in units of the scales above:

{rewards}

    `reward` may also be a function of one's own, or its path `"module:function"`, which keeps
    the arguments JSON: `reward(before, after, strides)` gets the (N, 4) post-strike states
    before and after N strides, pushes included (after a fall the one before), and the strides,
    a `StrideBatch`, whose `walked` and `outcome` tell falls; it gives (N,) numbers, each from
    its own row. They are `reward_stability`; a fall costs what the function says.

    `reward_effort` is −`effort_weight` times the stride's mechanical cost of transport
    (positive work over weight times step length); 0 by default, and on a fall.

    `info` has the same keys at every step and at reset, with NumPy's numbers and arrays:
    `state` (the true post-strike state α, s, α', β', rad and rad/s, without sensor noise; the
    last one after a fall), `control` (its numbers, SI units, torque noise included), `outcome`
    (a number; `env.unwrapped.outcome` and `powered_walker_env.Outcome` give its name), and

{info}

    Schemes other than the motor's have each number of the control by its name, too.

    ## Starting State

    On the nominal gait, just after a heel strike and its push (see Disturbances).
    `reset(options={{"state": (α, s, α', β')}})` starts exactly there.

    ## Episode End

    Termination: the walker falls; `info["outcome"]` says how. A step after it warns and
    changes nothing. Truncation: after 100 strides (the registered `max_episode_steps`).

    ## Arguments

    ```python
    gym.make("powered_walker_env:PoweredWalker-v0", reward="contraction", disturbance="rough")
    ```

{arguments}

    Control and gait that are left out are those of the preset, whose scheme cannot be
    changed: `scheme` chooses the first preset that has it if neither `preset` nor `params`
    is given. With `params` it says whose numbers `control` holds. A walker given by `params`,
    or a preset under another control, needs a gait: given, it is taken as it is; left out,
    it is searched, with `GaitNotFoundError` if there is none. Walkers without a motor
    (`passive`) are refused: they leave nothing to decide.

    `register_walker("MyWalker-v0", preset="round-foot", ...)` registers them under an id.

    ## Pictures

    `render_mode="rgb_array"` shows the end of the last stride; its `render_fps` is one
    picture for each stride of the nominal gait, so that `RecordVideo` and SB3's
    `VecVideoRecorder` play in real time. `"rgb_array_list"` gives every picture since the last
    `render()` or `reset()` (of the last 100 strides at most), 25 for each second of the walk;
    `"human"` opens a window. To film a walk, every picture of every stride, use
    `powered_walker_env.envs.RecordWalk(env, folder)` in the place of `RecordVideo`.

    Keys of the window: → and ← push the walker forwards and backwards at the next heel strike
    ({pushes} standard deviations of its pushes, of the light ones if it has none; felt in the
    observation), space pauses, s is for slow motion, r ends the episode (`truncated`), so that
    a loop that resets then starts again. A vector environment's window has no pushes and no r.

    `gymnasium.utils.play.play(env, fps=env.metadata["render_fps"], ...)` takes `"rgb_array"`,
    one picture a stride; `powered-walker explore` is a page to play with in the browser.

    ### Disturbances

    `"none"`, or pushes, {levels}; a level of another kind,
    as in `"light-ground"`; or a dict of standard deviations, as in
    `{{"push": 0.01, "torque": 0.02}}`. All draws are normal.

{kinds}

    ¹ {spread} of the motor: log-normal.
    The sizes of the levels, {levels}:

{sizes}

    The open loop falls about as soon under a level of any kind as under its pushes (but for
    sensor noise, which it does not feel, and torque noise and parameters of `hip-torque`,
    which bears any). A controller need not: the linear regulator walks 100 of 100 strides of
    the as-published walker under rough sensor noise. Other walkers take the sizes of
    `camp1997`, the push in proportion to √(g/L).

    ## Version History

    - v0: first release.
    - v1: `PoweredWalkerAsPublished` alone: action ranges three times as wide (±0.45 rad, ±9 %).
      v0, whose ±0.15 rad and ±3 % left little to win, stays registered.
"""


def describe() -> str:
    """The docstring of the environment."""
    return TEXT.format(
        ids=_ids(),
        schemes=_schemes(),
        ranges=_ranges(),
        angle=ANGLE_RANGE,
        strength=STRENGTH_RANGE,
        rewards="\n".join(_item(f'`reward="{name}"`: {words}.') for name, words in REWARDS.items()),
        info="\n".join(_item(f"`{name}`: {words}") for name, words in STRIDE_INFO.items()),
        arguments=_arguments(),
        pushes={1: "one", 2: "two", 3: "three"}[KEY_PUSHES],
        levels=", ".join(f'`"{level}"`' for level in LEVELS[1:]),
        kinds=_kinds(),
        spread=", ".join(name.replace("_", " ") for name in SPREAD_FIELDS),
        sizes=_sizes(),
    )


def _item(text: str) -> str:
    return textwrap.fill(text, 96, initial_indent="    - ", subsequent_indent="      ")


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    cells = [list(header), *map(list, rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = [
        "| " + " | ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)) + " |"
        for row in cells
    ]
    lines.insert(1, "|" + "|".join("-" * (w + 2) for w in widths) + "|")
    return "\n".join(f"    {line}" for line in lines)


def _ids() -> str:
    rows = [
        (f"`{env_id}`", f"`{name}`", PRESETS[name].params.physics)
        for env_id, (name, _) in ENVIRONMENTS.items()
    ]
    return _table(("Id", "Walker", "Physics"), rows)


def _schemes() -> str:
    rows = []
    for name, scheme in SCHEMES.items():
        if scheme.control is not None:
            numbers = [f"{each.name} ({each.unit})" for each in quantities(scheme.control).values()]
            rows.append((f"`{name}`", ", ".join(numbers)))
    return _table(("Scheme", "Control"), rows)


def _ranges() -> str:
    rows = []
    for name, _ in ENVIRONMENTS.values():
        control = PRESETS[name].control
        powered = scheme_of(control)
        units = [each.unit for each in quantities(powered.control).values()]
        nominal = [getattr(control, number) for number in powered.numbers]
        angle, strength = default_range(powered, name)
        rows.append(
            (
                f"`{name}`",
                ", ".join(f"{value:g} {unit}" for value, unit in zip(nominal, units, strict=True)),
                f"{angle:g} rad, {strength:.0%}",
            )
        )
    return _table(("Walker", "Nominal", "At ±1"), rows)


def _arguments() -> str:
    rows = [
        (f"`{field.name}`", f"`{field.default!r}`", field.metadata["meaning"])
        for field in dataclasses.fields(TaskArguments)
    ]
    mode = ("`render_mode`", "`None`", '`"human"`, `"rgb_array"` or `"rgb_array_list"`')
    return _table(("Argument", "Default", "Meaning"), [*rows, mode])


def _kinds() -> str:
    rows = [(f"`{kind}`", each.unit, each.label) for kind, each in quantities(Disturbance).items()]
    return _table(("Kind", "Unit", "Of what, and when it is drawn"), rows)


def _sizes() -> str:
    rows = [
        (f"`{name}`", *(", ".join(f"{size:g}" for size in sizes[kind]) for kind in KINDS))
        for name, sizes in SIZES.items()
    ]
    return _table(("Walker", *(f"`{kind}`" for kind in KINDS)), rows)
