"""The mechanics: a chain of links, what drives it, its guards, and its impacts.

Everywhere here a vector of the plane is one complex number, up + i·forward, and
⟨a, b⟩ = Re(ā b) is the inner product. Angles are absolute: foot φ, stance leg α
(ankle to hip), swing leg β (hip to ankle; of a bent one the shank, and θ its thigh), from the
floor's normal, forward positive. A pose is (φ, α, β, φ', α', β') and, with a knee, (θ, θ').

Every formula takes floats, in Python, or eight walkers at once, with or without tangents, in
kernels (`compiled/`).

- `constants`, `links`: the walker's numbers as the formulas need them, and its chains; `packing`:
  both as the kernels' row
- `chain`: mass matrix, bias, accelerations and energy of up to three links
- `actuation`: torques
- `ground`: the swing foot and the floor
- `guards`: the events that end a phase, one table
- `heel_strike`, `push_off`, `locking`: impacts
"""
