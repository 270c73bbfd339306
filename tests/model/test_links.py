"""Chains of any three links against Lagrange's equations of their points: the data of a chain are
all that a walker is."""

from __future__ import annotations

import math

import numpy as np
import pytest

from powered_walker_env.model.mechanics import chain
from powered_walker_env.model.mechanics.constants import Constants
from powered_walker_env.model.mechanics.links import Chain
from powered_walker_env.model.walker import WalkerParams
from tests.helpers.derivation import Array
from tests.helpers.samples import constants, derivative, random_motion
from tests.model.test_chain import assert_close


class Links:
    """Three links whose masses lie anywhere, on a round foot; vectors up + i·forward."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.masses, self.spins = rng.uniform(0.5, 2.0, 3), rng.uniform(0.1, 1.0, 3)
        vectors = rng.normal(size=(6, 2)) @ np.array([1.0, 1j])
        self.levers, self.places = vectors[:3], vectors[3:]
        self.radius, self.gravity = rng.uniform(0.1, 0.5), complex(*rng.normal(size=2))

    def lagrangian(self, y: Array) -> float:
        """Kinetic less potential energy, from where the masses are and how they move."""
        joint, moving = complex(0.0, self.radius * y[0]), complex(0.0, self.radius * y[3])
        total = 0.0
        for k in range(3):
            turned = complex(math.cos(y[k]), math.sin(y[k]))
            at = joint + self.places[k] * turned
            velocity = moving + 1j * self.places[k] * turned * y[3 + k]
            total += 0.5 * self.masses[k] * abs(velocity) ** 2 + 0.5 * self.spins[k] * y[3 + k] ** 2
            total -= self.masses[k] * (self.gravity.conjugate() * at).real
            joint += self.levers[k] * turned
            moving += 1j * self.levers[k] * turned * y[3 + k]
        return float(total)

    def chain(self) -> Chain:
        """Its levers, moments and inertias as `Chain` says them."""
        beyond = np.array([self.masses[1:].sum(), self.masses[2], 0.0])  # hangs on the link
        moments = self.masses * self.places + beyond * self.levers
        inertias = self.spins + self.masses * abs(self.places) ** 2 + beyond * abs(self.levers) ** 2
        inertias[0] += self.masses.sum() * self.radius**2
        names = ("inertia1", "inertia2", "inertia3")
        moment1, moment2, moment3 = moments.tolist()
        return Chain(
            lever1=complex(self.levers[0]), lever2=complex(self.levers[1]),
            moment1=moment1, moment2=moment2, moment3=moment3,
            **dict(zip(names, inertias.tolist(), strict=True)), share3=1.0 / float(inertias[2]),
            roll=float(self.masses.sum()) * self.radius,
            hip1=0.0, hip2=-1.0, hip3=1.0, hip0=0.0, ankle=1.0, knee=0.0,
        )  # fmt: skip

    def constants(self) -> Constants:
        """Half its mass stands for a leg's; there is no spring."""
        whole = 0.5 * float(self.masses.sum())
        walker = WalkerParams(foot_radius=self.radius, leg_mass=whole)
        return constants(walker)._replace(g=self.gravity)


def test_any_three_links_move_as_lagrange_has_it() -> None:
    """d/dt ∂L/∂θ' = ∂L/∂θ + torques: the data of a chain are all that a walker is."""
    rng = np.random.default_rng(18)
    for _ in range(30):
        links, y, (ankle, hip) = Links(rng), random_motion(rng), rng.normal(size=2)
        data, c = links.chain(), links.constants()
        at = chain.couplings(*np.exp(1j * y[:3]).tolist(), data, c)
        momenta = chain.momenta(chain.mass_matrix(at, data, c), *y[3:], c)
        by = [derivative(links.lagrangian, y, one) for one in np.eye(6)]
        assert_close(momenta, by[3:], 1e-11)
        accelerations = chain.accelerations(y, ankle, hip, data, c)
        flow = np.array([*y[3:], *accelerations])

        def momentum(state: Array, link: int, links: Links = links) -> float:
            return derivative(links.lagrangian, state, np.eye(6)[3 + link])

        change = [derivative(lambda s, k=k: momentum(s, k), y, flow) for k in range(3)]
        forces = by[:3] + np.array([ankle, -ankle - hip, hip])
        assert change == pytest.approx(forces, abs=1e-7 * (1 + np.abs(flow).max()))
