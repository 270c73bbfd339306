"""What the model assumes of a walk, and what the walk would need: the report on its contact."""

from __future__ import annotations

from dataclasses import dataclass

from powered_walker_env.model.phases import Outcome

STILL = 1e-9  # rad, m/L and rad/s·√(L/g): less than this is rounding


@dataclass(frozen=True)
class ContactReport:
    """Contact over one or more strides; the worst stride counts. NaN where nothing struck.

    Friction coefficients are infinite where the floor would have to pull.
    """

    outcome: Outcome  # of the last stride examined
    strides: int
    weight: float  # N, of the walker
    min_normal_force: float  # N, least normal force on the stance foot; below 0 it lifts off
    max_normal_force: float  # N
    friction: float  # least coefficient that keeps the stance foot from slipping
    min_stop_torque: float  # N m, the stop's on the locked foot beside a motor's; below 0 it would
    # need a latch
    min_clearance: float  # m, of the swing foot after the legs have passed; below 0 it scuffs
    max_clearance: float  # m, likewise; at most 0: it never comes up through the floor
    deepest: float  # m, lowest height of the swing foot in the whole swing
    min_ankle_height: float  # m, of either ankle above the floor
    trailing_ankle_velocity: float  # m/s, upward, just after heel strike
    trailing_foot_velocity: float  # m/s, upward, of the old foot's lowest point just after heel
    # strike, its ankle held as it was; below 0 it would press into the floor
    normal_impulse: float  # N s, of the floor on the new foot at heel strike, least
    strike_friction: float  # least coefficient that keeps the new foot from slipping there
    stop_overrun: float  # rad, how far the powered foot falls back past its stop, q2 − q2_lock
    ankle_reversals: int  # times the ankle turns round while the motor runs
    min_stance_knee_torque: float  # N m, of the locked stance knee on its shank; below 0 it would
    # need a latch, as a stop only keeps it from bending back; NaN without knees, as those below
    max_stance_knee_torque: float  # N m
    min_swing_knee_torque: float  # N m, the same of the swing knee once it has struck
    knee_impulse: float  # N s, normal, of the floor on the stance foot at knee strike
    knee_friction: float  # least coefficient that keeps the stance foot from slipping there

    def __repr__(self) -> str:
        found = "; ".join(self.violations()) or "nothing that the model assumes is broken"
        strides = f"{self.strides} stride{'s' * (self.strides != 1)}"
        return f"ContactReport({strides}, {self.outcome.label}: {found})"

    @property
    def min_normal_fraction(self) -> float:
        """Least normal force as a fraction of the weight."""
        return self.min_normal_force / self.weight

    @property
    def keeps_contact(self) -> bool:
        """Whether the floor only ever pushes the stance foot."""
        return self.min_normal_force > 0.0

    @property
    def stop_suffices(self) -> bool:
        """Whether a stop that can only push holds the foot in the passive swing."""
        return self.min_stop_torque >= -STILL * self.weight  # at its release it is zero

    @property
    def scuffs(self) -> bool:
        """Whether the swing foot goes under the floor after the legs have passed."""
        return self.min_clearance < -STILL

    @property
    def ankles_stay_above(self) -> bool:
        """Whether no ankle dips under the floor."""
        return self.min_ankle_height >= 0.0

    @property
    def trailing_foot_lifts(self) -> bool:
        """Whether the old foot leaves the floor at heel strike by itself."""
        return self.trailing_foot_velocity >= 0.0

    @property
    def strike_pushes(self) -> bool:
        """Whether the floor pushes the new foot at heel strike."""
        return self.normal_impulse > 0.0

    @property
    def falls_back(self) -> bool:
        """Whether the powered foot falls back past its stop."""
        return self.stop_overrun > STILL

    @property
    def extends_monotonely(self) -> bool:
        """Whether the powered foot only ever extends."""
        return not self.falls_back and self.ankle_reversals == 0

    def violations(self, friction: float = 1.0) -> tuple[str, ...]:
        """What the model assumes and this walk would not do on a floor of that friction."""
        found = [
            (not self.keeps_contact, f"the stance foot lifts off: least normal force "
             f"{self.min_normal_fraction:.3g} of the weight"),
            (self.friction > friction, f"the stance foot slips: it needs a friction coefficient "
             f"of {self.friction:.3g}"),
            (not self.stop_suffices, "the stop must hold the foot back, as a latch: "
             f"{self.min_stop_torque:.4g} N m"),
            (self.min_stance_knee_torque < -STILL * self.weight, "the stance knee must be held "
             f"straight, as by a latch: {self.min_stance_knee_torque:.4g} N m"),
            (self.min_swing_knee_torque < -STILL * self.weight, "the swing knee must be held "
             f"straight once it has struck, as by a latch: {self.min_swing_knee_torque:.4g} N m"),
            (self.knee_impulse <= 0, "the floor would have to pull at knee strike: "
             f"{self.knee_impulse:.4g} N s"),
            (self.knee_friction > friction, "the stance foot slips at knee strike: it needs a "
             f"friction coefficient of {self.knee_friction:.3g}"),
            (self.scuffs, f"the swing foot scuffs after mid-swing: {self.min_clearance:.3g} m"),
            (not self.ankles_stay_above, f"an ankle is under the floor: "
             f"{self.min_ankle_height:.3g} m"),
            (self.trailing_foot_velocity < 0, "the trailing foot does not lift at heel strike: "
             f"{self.trailing_foot_velocity:.3g} m/s"),
            (self.normal_impulse <= 0, "the floor would have to pull at heel strike: "
             f"{self.normal_impulse:.4g} N s"),
            (self.strike_friction > friction, "the new foot slips at heel strike: it needs a "
             f"friction coefficient of {self.strike_friction:.3g}"),
            (self.falls_back, f"the foot falls back past its stop: {self.stop_overrun:.3g} rad"),
        ]  # fmt: skip
        return tuple(text for broken, text in found if broken)
