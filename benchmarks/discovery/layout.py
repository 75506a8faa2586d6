"""Where every number of the two-link simulator stands in its table `P` (joints, COLUMNS), one row per joint.

The friction columns come twice, from LINK on for the link's side and from MOTOR on for the motor's; a column that is
zero (or infinite, for stall torque and stops) is an effect that is not there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LINK, MOTOR = 0, 16
VISCOUS, POSITIVE, NEGATIVE, EXCESS, VELOCITY, EXPONENT, QUADRATIC, LOAD = range(8)
SWING, SWING_HARMONIC, SWING_PHASE, LEVEL, BRISTLE, BRISTLE_DAMPING, WARM, WARM_TIME = range(8, 16)
K, D, CUBIC, HALF_GAP, HYSTERESIS, WIDTH, ERROR, ERROR_HARMONIC, ERROR_PHASE = range(32, 41)
GAIN, OFFSET, RIPPLE, RIPPLE_HARMONIC, RIPPLE_PHASE, STALL, NO_LOAD, DELAY = range(41, 49)
PARALLEL, REST, COS_1, SIN_1, COS_2, SIN_2, LOWER, UPPER, STOP, STOP_DAMPING = range(49, 59)
COUPLING, ROTOR, RIGID = 59, 60, 61
# Outside the catalogue:
CUBIC_DRAG, PATCHY, PATCHY_HARMONIC, BREATHING, BREATHING_RATE, SAG, DRIFT, FAN, FAN_RATE = range(62, 71)
WEAR, CABLE, ROOT_DAMPING, MODE_INERTIA, MODE_STIFFNESS, MODE_DAMPING = range(71, 77)
PULL = 77  # torque of the cables on the link at this sample (cables.py) [N m]
COLUMNS = 78

# The links in the five numbers that their motion depends on: M11 = FIXED + 2 TURN cos q2, M12 = OUTER + TURN cos q2,
# M22 = OUTER; gravity torques WEIGHT_1 cos q1 + WEIGHT_2 cos(q1 + q2) and WEIGHT_2 cos(q1 + q2).
FIXED, TURN, OUTER, WEIGHT_1, WEIGHT_2 = range(5)

# The state: link and rotor positions, their velocities, angle and velocity of a mass that swings on the arm.
STATES = 10


def neutral() -> Array:
    """Two joints without any effect; springs, rotors and dampers are still to be filled in (2, COLUMNS)."""
    P = np.zeros((2, COLUMNS))
    for side in (LINK, MOTOR):
        P[:, side + VELOCITY] = P[:, side + EXPONENT] = P[:, side + WARM_TIME] = 1.0
    P[:, WIDTH] = 1.0
    P[:, STALL], P[:, NO_LOAD] = np.inf, 1.0
    P[:, LOWER], P[:, UPPER] = -np.inf, np.inf
    return P
