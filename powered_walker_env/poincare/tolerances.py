"""Tolerances that mean the same wherever they are met: one name, one value, and why.

Of strides, the accuracy asked (`rtol`); of states, distances in natural units (radians, and
radians per √(L/g)).
"""

# Strides, from the exact to the many.
GAIT_RTOL = 1e-13  # behind a gait and its derivatives: rounding is all that is left
CONTACT_RTOL = 1e-11  # with thousands of samples, whose extremes are right to 1e-6 anyway
ORBIT_RTOL = 1e-10  # along an orbit: chaos forgets more than that in a few strides
SEARCH_RTOL = 1e-9  # of a search, whose finds are refined, and of a norm checked by samples
RAMP_RTOL = 1e-9  # of strides walked on and on: what they settle on forgets their errors
FATE_RTOL = 1e-8  # of strides of which it is asked where they lead, not their digits

# States.
RESIDUAL = 1e-11  # of a fixed point: what strides of GAIT_RTOL can still be told apart by
SAME_STATE = 1e-6  # of one cycle: 10⁵ residuals, far below the halves of any doubled gait met
NEARLY_BACK = 1e-4  # of a walker that has come back, settled or not quite
SHORTEST_STRIDE = 1e-3  # leg lengths; less is standing, where the equations are all rounding

# Searches.
SETTLING = 400  # strides, for each of a gait's period, walked before Newton takes over
NEWTON_STEPS = 40  # damped: a start that needs more is in no gait's reach
LONGEST_PERIOD = 1024  # strides of a gait that is asked for: ten doublings
