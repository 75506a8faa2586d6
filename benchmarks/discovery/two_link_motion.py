"""Integrates the two-link arm: fourth order between corners, dry friction that sticks to the last bit.

Every step is a Runge-Kutta step during which each body slides one way or sticks. A body that would turn round is
stopped at the instant where its velocity is zero; whether it stays is decided there by trying all ways to go on.
"""

from __future__ import annotations

import layout as at
import numpy as np
from compiled import compiled
from layout import Array
from numpy.typing import NDArray
from two_link_forces import (
    FORCES,
    LINK_LEAST,
    LINK_MOST,
    M11,
    M12,
    M22,
    MODE_1,
    MODE_2,
    MOTOR_LEAST,
    MOTOR_MOST,
    NET_LINK,
    NET_MOTOR,
    bend,
    forces,
    wound,
)

Ways = NDArray[np.int64]
STUCK, FREE = 0, 2  # besides +1 and -1: sliding this way; free: no dry friction at all
AT_REST = 1e-11  # rad/s: an instant of standstill is found to this


@compiled
def held(F: Array, most: int, least: int, way: int) -> float:
    """Dry friction of a body that slides this way [N m]."""
    return F[most] if way == 1 else -F[least] if way == -1 else 0.0


@compiled
def link_accelerations(F: Array, one: int, two: int) -> tuple[float, float, float, float]:
    """Accelerations of both links, and the friction that each needs where it sticks, for one choice of ways."""
    b1 = F[NET_LINK] - held(F, LINK_MOST, LINK_LEAST, one)
    b2 = F[NET_LINK + 1] - held(F, LINK_MOST + 1, LINK_LEAST + 1, two)
    if one == STUCK and two == STUCK:
        return 0.0, 0.0, b1, b2
    if one == STUCK:
        a2 = b2 / F[M22]
        return 0.0, a2, b1 - F[M12] * a2, 0.0
    if two == STUCK:
        a1 = b1 / F[M11]
        return a1, 0.0, 0.0, b2 - F[M12] * a1
    determinant = F[M11] * F[M22] - F[M12] * F[M12]
    return (F[M22] * b1 - F[M12] * b2) / determinant, (F[M11] * b2 - F[M12] * b1) / determinant, 0.0, 0.0


@compiled
def consistent(F: Array, j: int, way: int, a: float, need: float) -> bool:
    """Whether a link at rest may go on this way."""
    if way == STUCK:
        return bool(-F[LINK_LEAST + j] <= need <= F[LINK_MOST + j])
    return way * a > 0.0


@compiled
def way_of(u: float, most: float, least: float) -> int:
    """Way of a moving body, FREE without dry friction, STUCK if that is still to be decided."""
    return FREE if most + least <= 0.0 else 1 if u > 0.0 else -1 if u < 0.0 else STUCK


@compiled
def decide(F: Array, y: Array, P: Array, way: Ways) -> None:
    """Way of links (0, 1) and rotors (2, 3) from here on."""
    for j in range(2):
        way[j] = way_of(y[4 + j], F[LINK_MOST + j], F[LINK_LEAST + j])
        way[2 + j] = way_of(y[6 + j], F[MOTOR_MOST + j], F[MOTOR_LEAST + j])
        if P[j, at.RIGID] > 0.0:
            way[2 + j] = FREE
        elif way[2 + j] == STUCK:
            net = F[NET_MOTOR + j]
            way[2 + j] = 1 if net > F[MOTOR_MOST + j] else -1 if net < -F[MOTOR_LEAST + j] else STUCK
    rest_1, rest_2 = way[0] == STUCK, way[1] == STUCK
    if not (rest_1 or rest_2):
        return
    for one in range(-1, 2):
        for two in range(-1, 2):
            if (not rest_1 and one != 0) or (not rest_2 and two != 0):
                continue
            w1, w2 = one if rest_1 else int(way[0]), two if rest_2 else int(way[1])
            a1, a2, need_1, need_2 = link_accelerations(F, w1, w2)
            if rest_1 and not consistent(F, 0, w1, a1, need_1):
                continue
            if rest_2 and not consistent(F, 1, w2, a2, need_2):
                continue
            way[0], way[1] = w1, w2
            return


@compiled
def rates(
    t: float, y: Array, start: Array, memory: Array, tau: Array, P: Array, links: Array, way: Ways, F: Array, dy: Array
) -> None:
    """Accelerations and velocities at a state while every body keeps its way, into dy."""
    forces(t, y, start, memory, tau, P, links, F)
    a1, a2, _, _ = link_accelerations(F, way[0], way[1])
    dy[0], dy[1], dy[4], dy[5] = y[4], y[5], a1, a2
    for j in range(2):
        if P[j, at.RIGID] > 0.0:
            dy[2 + j], dy[6 + j] = dy[j], dy[4 + j]
        else:
            dy[2 + j] = y[6 + j]
            friction = held(F, MOTOR_MOST + j, MOTOR_LEAST + j, way[2 + j])
            dy[6 + j] = 0.0 if way[2 + j] == STUCK else (F[NET_MOTOR + j] - friction) / P[j, at.ROTOR]
    dy[8], dy[9] = F[MODE_1], F[MODE_2]


@compiled
def runge_kutta(
    t: float, h: float, y: Array, memory: Array, tau: Array, P: Array, links: Array, way: Ways, F: Array, W: Array
) -> None:
    """One step of the classical method from y into W[5]; W (6, STATES) is room to work in."""
    rates(t, y, y, memory, tau, P, links, way, F, W[0])
    W[4] = y + 0.5 * h * W[0]
    rates(t + 0.5 * h, W[4], y, memory, tau, P, links, way, F, W[1])
    W[4] = y + 0.5 * h * W[1]
    rates(t + 0.5 * h, W[4], y, memory, tau, P, links, way, F, W[2])
    W[4] = y + h * W[2]
    rates(t + h, W[4], y, memory, tau, P, links, way, F, W[3])
    W[5] = y + h / 6.0 * (W[0] + 2.0 * W[1] + 2.0 * W[2] + W[3])


@compiled
def turned(y: Array, new: Array, way: Ways) -> int:
    """The body that turns round first within a step, -1: none."""
    first, share = -1, 2.0
    for body in range(4):
        if (way[body] == 1 or way[body] == -1) and new[4 + body] * way[body] < -AT_REST and y[4 + body] != 0.0:
            when = y[4 + body] / (y[4 + body] - new[4 + body])
            if when < share:
                first, share = body, when
    return first


@compiled
def stop_at(
    body: int,
    t: float,
    h: float,
    y: Array,
    memory: Array,
    tau: Array,
    P: Array,
    links: Array,
    way: Ways,
    F: Array,
    W: Array,
) -> float:
    """The share of a step after which this body is at rest, by false position (Illinois); W[5] is the state there."""
    low, high, side = 0.0, h, 0
    above, below = y[4 + body] * way[body], W[5][4 + body] * way[body]
    middle = h
    for _ in range(60):
        middle = (low * below - high * above) / (below - above)
        runge_kutta(t, middle, y, memory, tau, P, links, way, F, W)
        u = W[5][4 + body] * way[body]
        if abs(u) < AT_REST or high - low < 1e-17:
            break
        if u > 0.0:
            low, above = middle, u
            below = 0.5 * below if side == 1 else below
            side = 1
        else:
            high, below = middle, u
            above = 0.5 * above if side == -1 else above
            side = -1
    return middle


@compiled
def hold(t: float, y: Array, memory: Array, tau: Array, P: Array, links: Array, way: Ways, F: Array, W: Array) -> float:
    """How far the resting bodies are from breaking away at the state W[5], the nearest of them [N m]."""
    margin = 1.0
    if way[0] == STUCK or way[1] == STUCK or way[2] == STUCK or way[3] == STUCK:
        forces(t, W[5], y, memory, tau, P, links, F)
        _, _, need_1, need_2 = link_accelerations(F, way[0], way[1])
        for j in range(2):
            need = need_1 if j == 0 else need_2
            if way[j] == STUCK:
                margin = min(margin, F[LINK_MOST + j] - need, F[LINK_LEAST + j] + need)
            if way[2 + j] == STUCK:
                margin = min(margin, F[MOTOR_MOST + j] - F[NET_MOTOR + j], F[MOTOR_LEAST + j] + F[NET_MOTOR + j])
    return margin


@compiled
def break_away(
    t: float, h: float, y: Array, memory: Array, tau: Array, P: Array, links: Array, way: Ways, F: Array, W: Array
) -> float:
    """The first share of a step after which a resting body is past its bound, by halving; W[5] is the state there."""
    low, high = 0.0, h
    while high - low > 1e-10:
        middle = 0.5 * (low + high)
        runge_kutta(t, middle, y, memory, tau, P, links, way, F, W)
        if hold(t + middle, y, memory, tau, P, links, way, F, W) < 0.0:
            high = middle
        else:
            low = middle
    runge_kutta(t, high, y, memory, tau, P, links, way, F, W)
    return high


@compiled
def to_the_turn(
    t: float, h: float, y: Array, memory: Array, tau: Array, P: Array, links: Array, way: Ways, F: Array, W: Array
) -> float:
    """Step to h or to the first turn of a sliding body, which then rests; the step taken."""
    runge_kutta(t, h, y, memory, tau, P, links, way, F, W)
    body, last = turned(y, W[5], way), -1
    for _ in range(4):
        if body < 0:
            break
        h, last = stop_at(body, t, h, y, memory, tau, P, links, way, F, W), body
        body = turned(y, W[5], way)
    if hold(t + h, y, memory, tau, P, links, way, F, W) < 0.0:
        h, last = break_away(t, h, y, memory, tau, P, links, way, F, W), -1
    if last >= 0:
        W[5][4 + last] = 0.0
    for k in range(4):
        # Left from rest and fell back at once, or a second body at the same instant: it rests.
        if (way[k] == 1 or way[k] == -1) and W[5][4 + k] * way[k] < 0.0:
            W[5][4 + k] = 0.0
    for j in range(2):
        if P[j, at.RIGID] > 0.0:
            W[5][6 + j] = W[5][4 + j]
    return h


@compiled
def remember(y: Array, new: Array, P: Array, memory: Array) -> None:
    """Bristles and hysteresis along the way from y to new."""
    for j in range(2):
        moved = new[j] - y[j]
        turned_by = moved if P[j, at.RIGID] > 0.0 else new[2 + j] - y[2 + j]
        for side, way in ((0, moved), (1, turned_by)):
            base = at.MOTOR if side else at.LINK
            if P[j, base + at.LEVEL] > 0.0:
                memory[side, j] = bend(way, memory[side, j], P[j, base + at.LEVEL] / P[j, base + at.BRISTLE])
        if P[j, at.HYSTERESIS] > 0.0:
            delta = wound(P, j, new[j], new[2 + j]) - wound(P, j, y[j], y[2 + j])
            memory[2, j] = bend(delta, memory[2, j], P[j, at.WIDTH])


@compiled
def advance(t: float, end: float, step: float, y: Array, memory: Array, tau: Array, P: Array, links: Array) -> None:
    """Move y and memory from t to end under held torques."""
    F, W, way = np.zeros(FORCES), np.zeros((6, at.STATES)), np.zeros(4, np.int64)
    while end - t > 1e-13:
        forces(t, y, y, memory, tau, P, links, F)
        decide(F, y, P, way)
        count = max(1, int(np.ceil((end - t) / step - 1e-9)))
        h = to_the_turn(t, (end - t) / count, y, memory, tau, P, links, way, F, W)
        remember(y, W[5], P, memory)
        y[:] = W[5]
        t += h
