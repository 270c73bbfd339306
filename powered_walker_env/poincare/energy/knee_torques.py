"""What locked knees bear: the torques of their stops on the shanks.

The stance knee bears what its shank needs beside the floor's force; with K the knee, C the contact
point and s the shank's centre of mass,

    τ_K = I_s α'' + ⟨i(s − K), m_s (s'' + g)⟩ − ⟨i(C − K), F⟩ on the shank,

and so does the straight swing knee, where no floor acts. A stop that keeps the knee from bending
back pushes the shank forward: τ_K > 0. Below zero the knee would buckle, were it not latched.
"""

from __future__ import annotations

from powered_walker_env.model.knee import Knee
from powered_walker_env.model.mechanics.actuation import Accelerations
from powered_walker_env.model.mechanics.chain import Pose, cross
from powered_walker_env.model.mechanics.constants import Constants


def _turned(arm: complex, spin: float, rate: float) -> complex:
    """Acceleration of the end of an arm that turns."""
    return (1j * spin - rate**2) * arm


def _ankle_acceleration(pose: Pose, turning: Accelerations, c: Constants) -> complex:
    return 1j * c.R * turning.phi + _turned(c.D * pose.foot, turning.phi, pose.dphi)


def stance_knee(
    pose: Pose, turning: Accelerations, force: complex, knee: Knee, c: Constants
) -> float:
    """Torque on the stance leg's shank at its knee, N m."""
    com = complex(knee.shank_com_along, knee.shank_com_across) * pose.stance
    length = knee.shank_length * pose.stance
    moved = _ankle_acceleration(pose, turning, c) + _turned(com, turning.alpha, pose.dalpha)
    needed = knee.shank_inertia * turning.alpha
    needed += knee.shank_mass * cross(com - length, moved + c.g)
    return float(needed + cross(c.R + c.D * pose.foot + length, force))


def swing_knee(pose: Pose, turning: Accelerations, knee: Knee, c: Constants) -> float:
    """Torque on the straight swing leg's shank at its knee, N m."""
    arm = complex(knee.shank_length - knee.shank_com_along, -knee.shank_com_across) * pose.swing
    moved = _ankle_acceleration(pose, turning, c)
    moved += _turned(c.L * pose.stance, turning.alpha, pose.dalpha)
    moved += _turned(c.thigh * pose.thigh, turning.theta, pose.dtheta)
    moved += _turned(arm, turning.beta, pose.dbeta)
    needed = knee.shank_inertia * turning.beta
    return float(needed + knee.shank_mass * cross(arm, moved + c.g))
