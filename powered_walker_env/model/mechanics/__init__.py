"""The mechanics: swing, actuation, ground contact and heel strike, as compiled functions.

Everywhere here a vector of the plane is one complex number, up + i·forward, and
⟨a, b⟩ = Re(ā b) is the inner product. Angles are absolute: foot φ, stance leg α
(ankle to hip), swing leg β (hip to ankle), from the floor's normal, forward positive.
"""
