"""The constants that decide what a diagnosis says, each with its source; the method page has the same table.

Those after "Derived" follow from the others. Budgets and tolerances of the numerics, which cost time and seldom change
a result, stand where they are used.
"""

from __future__ import annotations

import math

# Data and noise
TEST_SHARE = 0.2
"""Share of the moving part of every recording that is test data if none are given [1]. Source: contract, section
8."""
CERTAIN_SIGMAS = 5.0
"""Standard deviations that chance does not reach, once in 10^6 [1]: of a velocity's sign, and of a sum of squares."""
NOISE_LEVEL_ERROR = 0.05
"""Relative uncertainty of the power of the sensors' noise [1]. Choice."""
STRAY_SHARE = 0.1
"""Share of the simulated windows that may be far off [1]. Choice: noise decides when a joint sticks, and windows in
which that matters are fewer."""
ERRORS_PER_WINDOW = 20
"""Independent errors in a simulated window of 0.5 s of one joint, about [1]. Choice."""

# Priors
EFFECT_TORQUE_SHARE = 0.3
"""Prior standard deviation of an effect's torque over the root mean square torque of its joint [1]. Choice: friction
and similar effects take up to some 30 % of a drive."""
SMALLEST_TORQUE_SHARE = 4e-3
"""Share of its joint's torque from which an effect is one [1]. Choice: no model of a robot is more accurate."""
NEGLIGIBLE_SHARE = 3e-3
"""Standard deviation of a negligible effect over that of a real one [1]: 0.1 % of the joint's torque, with
`EFFECT_TORQUE_SHARE`."""
LEAST_DAMPING_RATIO = 0.002
"""Damping ratio of a joint's vibration from which a damping of its transmission is an effect [1]. Choice: steel alone
has that much."""
FREED_WIDTH = 1.0
"""Prior standard deviation of the factor of a number whose tolerance is wrong [1]. Choice: a factor of two is nothing
special."""
IN_TOLERANCE = 3.0
"""Standard deviations of its tolerance within which a number of the file is calibrated and not wrong [1]: 0.3 % of
right numbers are beyond."""
FIXED_SIZE_WIDTH = 0.05
"""Prior standard deviation of the size of an effect that enters at one grid point, about 1 [1]: the grid is that
coarse."""
PLACE_BETA = (0.3, 6.0)
"""Beta prior of the share of places that have an effect [1]: odds of 1 to 20 for a single place, better if other
places have it already. So an effect of many joints costs less than single effects. Source: Scott and Berger, 2010;
the numbers are a choice."""
EVERYWHERE = 100.0
"""Prior odds of an effect that every drive has to something unknown that looks like it [1]. Choice."""
OFTEN = 15.0
"""The same of what most drives have [1]. Choice."""
SELDOM = 0.3
"""The same of all other effects [1]. In 24 hidden cases outside the catalogue the best imitation stood out by 46 at
most; an effect must by 60 to be named."""

# Comparison
ESTABLISHED = 0.95
"""Posterior probability from which an effect, or an "A or B", counts as established [1]. Source: contract, section
8."""
OCCAM_WINDOW = math.log(1000.0)
"""Log odds to the best structure beyond which a structure is not explored [1]. Source: Madigan and Raftery, 1994."""
EVEN_ODDS_WINDOW = math.log(3.0)
"""Log Bayes factor up to which data do not tell two laws apart [1]: evidence up to 3 is "not worth more than a bare
mention". Source: Kass and Raftery, J. Am. Stat. Assoc. 90, 1995."""
WORTHWHILE_GAIN = 5.0
"""Log likelihood that is worth a further step of a fit, or a number that is not whole [1]: odds change by more than
100."""
RIVAL_LOSS = 0.01
"""Share of a candidate's gain by which the linear equations may be wrong [1]: a rival that loses less is fitted.
Choice: a rival that a fit preferred had lost 0.03 %."""
STRONG_GAIN_SHARE = 0.1
"""Share of the greatest gain of a pass from which another addition is made before the equations are linearised anew,
or a candidate is fitted alone where they do not keep their promise; and share of a gain that a candidate may lose to be
simulated in the place of another one [1]. Choice."""
RIVAL_PROBABILITY = 0.02
"""Probability from which a candidate is reported as a rival of another [1]: rivals below it together hardly reach 5
%."""
LEAST_IN_COMMON = 0.1
"""Share of the power of a candidate that a rival must be able to make [1]. Choice: friction of another joint had 2e-8
in common with a wave, a rival 0.9999."""
LEFT_TORQUE_SHARE = 0.01
"""Share of a joint's torque from which something is left [1]. Choice: no model of a robot is more accurate."""

# Derived
REST_SIGMAS = 2.0 * CERTAIN_SIGMAS
"""A joint rests if the range of its position is below this number of standard deviations of its encoder's noise [1]:
in about a hundred samples, noise alone has a range of five or six."""
SHOWN_DEFLECTION = CERTAIN_SIGMAS**2
"""Power of a deflection over that of its noise from which both encoders tell an unknown stiffness [1]: chance does not
reach `CERTAIN_SIGMAS`, and the noise is 4 % of the slope by K, less than `NOISE_LEVEL_ERROR`."""
FREED_TOLERANCES = 10.0 * FREED_WIDTH
"""`FREED_WIDTH` in tolerances, where the tolerance itself is wider: ten tolerances are nothing special then."""
UBIQUITOUS_BETA = (PLACE_BETA[1], PLACE_BETA[0])
"""`PLACE_BETA` of friction that every motor has, where the file has none [1]: odds of 20 to 1."""
PLAIN_BETA = (1.0, 1.0)
"""`PLACE_BETA` of the same friction on links [1]: any share of the places is as likely as any other."""
PREVALENCE_ODDS = {"everywhere": EVERYWHERE, "often": OFTEN, "seldom": SELDOM}
"""Prior odds by the `prevalence` that an effect's class declares [1]."""
ON_LINKS = {"everywhere": OFTEN, "often": SELDOM, "seldom": SELDOM}
"""Of friction behind the gear [1]: drives have theirs in motor and gear, and a link's bearings add little."""
WHOLE_NUMBER_LOG_ODDS = WORTHWHILE_GAIN
"""Log odds of a harmonic that is a whole number, or a whole number of motor turns, to one that is not [1]."""
PROMISED_DROP = 2.0 * WORTHWHILE_GAIN
"""A fit has not converged if its next step would decrease chi^2, twice the log likelihood, by more than this [1]."""
LEAST_DESCENT = PROMISED_DROP / 2.0
"""Decrease of chi^2 that is worth a further step along its exact slopes [1]."""
NOISE_GAP = round(1.0 + 2.0 / math.sqrt(2.0 * ERRORS_PER_WINDOW), 1)
"""A gap of at most this multiple of the floor is noise [1]: two standard deviations of a window's root mean
square."""
LIKELY_IMITATION = 0.5
"""Probability of being genuine below which a law is more likely an imitation of something unknown [1]."""
