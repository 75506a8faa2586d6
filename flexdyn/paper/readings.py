"""Ambiguities and misprints of the paper, and the chosen reading, with a measured reason if there is one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn.paper import equations as eq
from flexdyn.paper.cases import AMPLITUDE, PULSE, PaperCases
from flexdyn.paper.verification import random_states, tip_acceleration

AREA_MOMENT = 9.9e-12  # m^4: I_1 = I_2 of Table I


@dataclass(frozen=True)
class Reading:
    """One place of the paper.

    Attributes:
        where: equation, table, figure or section.
        printed: the printed text.
        read_as: the reading that is used.
        why: the reason, with numbers measured by this study.
    """

    where: str
    printed: str
    read_as: str
    why: str


def readings(cases: PaperCases) -> tuple[Reading, ...]:
    """All of them: misprints in equations, then symbols, Table I, what is missing, figures."""
    return (*_misprints(cases.arm()), *_symbols(), *_table(cases), *_missing(cases), *_figures())


def _misprints(arm: eq.Arm) -> tuple[Reading, ...]:
    q, v, _ = random_states()
    accelerations = np.random.default_rng(1).uniform(-5.0, 5.0, q.shape)
    measured, _ = tip_acceleration(arm, q, v, accelerations)
    without = np.abs(np.einsum("tij,tj->ti", eq.jacobian(arm, q), accelerations) - measured).max()
    wrong = np.abs(eq.jacobian_as_printed(arm, q) - eq.jacobian(arm, q)).max(0)
    return (
        Reading(
            "eq. 2",
            "sgn(0) = 0",
            "Sgn(0) = [-1, 1], set-valued",
            "with 0 a loaded joint at rest feels no friction; section 3 calls b^s the torque that starts a motion",
        ),
        Reading(
            "eq. 6, 7",
            "J_r q'' = R_t, with R_t nowhere defined",
            "J_r q'' + (dJ_r/dt) q' = acceleration of the tip (J_r q' = its velocity)",
            f"J_r q'' alone misses the tip's acceleration by up to {without:.0f} m/s^2 at random states (to 3 rad/s)",
        ),
        Reading(
            "eq. 10",
            "J_r21 = -l_1 cos q_1 + l_2 cos(q_1 + q_2)",
            "J_r21 = +l_1 cos q_1 + l_2 cos(q_1 + q_2)",
            f"as printed it misses Pinocchio's Jacobian by up to {wrong[1, 0]:.2f} m, corrected it equals it",
        ),
        Reading(
            "eq. 11",
            "J_r22 = I_2 cos(q_1 + q_2)",
            "J_r22 = l_2 cos(q_1 + q_2)",
            f"an inertia is no length; with I_2 it misses Pinocchio's Jacobian by up to {wrong[1, 1]:.2f} (m)",
        ),
        Reading(
            "eq. 17",
            "D_22 = m_2 I_c2^2 + I_2 + m_L I_2^2 + I_L",
            "D_22 = m_2 l_c2^2 + I_2 + m_L l_2^2 + I_L",
            f"{eq.D22(arm):.4f} kg m^2 equals Pinocchio's M_22; with I_2^2 in the last term by the letter it would be "
            f"{eq.D22_as_printed(arm):.4f}",
        ),
        Reading(
            "eq. 14, 15", "a bar over q_3 and q_4", "two dots: q_3'', q_4''", "a torque balance needs J times them"
        ),
        Reading(
            "eq. 12, 13, 19",
            "-C q_2'^2 - 2 C q_1' q_2' and +C q_1'^2",
            "as printed",
            "not a misprint: signs and factors equal Pinocchio's Coriolis torques",
        ),
    )


def _symbols() -> tuple[Reading, ...]:
    return (
        Reading(
            "eq. 1",
            "b_k^y; |q_k'| garbled in the exponent",
            "b_k^v, exp(-|q_k'|/epsilon)",
            "the sentence below eq. 1 names b_k^v; with |q_k'| the law tends to +-b_k^s at rest, as the text says",
        ),
        Reading(
            "eq. 20, 21",
            "v_i q_i' + k_i sgn(q_i') only",
            "the whole eq. 1: v = b^v, k = b^d, and the Stribeck term",
            "section 3 presents eq. 1 as the law; eq. 20, 21 are it without the term that fades with speed",
        ),
        Reading(
            "section 4",
            "q_1 = {q_1, q_3, ...} link angles, q_2 = {q_2, q_4, ...} rotor angles",
            "links q_1, q_2, rotors q_3, q_4",
            "only so do eq. 12-15 have the form of eq. 3, 4",
        ),
        Reading(
            "eq. 3",
            "C(q_1, q_1') \"the vector of damping, Coriolis and centripetal forces\", printed times q_1'",
            "a matrix times q_1', Coriolis and centrifugal only; damping stands in b once",
            "eq. 12, 13 have it so; gravity G = 0, the axes being vertical",
        ),
        Reading(
            "k",
            "k_i: stiffness (nomenclature), Coulomb level (eq. 20, 21), actuator constant (Table I); K_1 = k_2 = 5.5",
            "told apart by place; K_1 = K_2 = 5.5",
            "eq. 12-15 write one K, and one J, for both joints",
        ),
        Reading(
            "eq. 16-19, Table I",
            "m_L and I_L in the equations, m_e in the table, no I_L",
            "m_L = m_e = 0.1 kg, I_L = 0",
            "a point mass at the end",
        ),
        Reading("eq. 5", "there is none between eq. 4 and eq. 6", "nothing is missed", "no text refers to it"),
    )


def _table(cases: PaperCases) -> tuple[Reading, ...]:
    arm = cases.arm()
    radius = (4 * AREA_MOMENT / np.pi) ** 0.25
    density = arm.mu / (np.pi * radius**2)
    return (
        Reading("Table I", "K in N/m", "N m/rad", "K multiplies angles and gives torques in eq. 12-15"),
        Reading(
            "Table I",
            "area moment of inertia I = 9.9e-12 m^4",
            f"mass moment of a slender uniform rod, m L^2/12 = {arm.inertia:.4f} kg m^2; l_c = L/2",
            "eq. 16-18 need kg m^2, and rigid links have no use for an area moment. Without the rod's own inertia D_22 "
            f"would be {100 * arm.inertia / eq.D22(arm):.0f} % less. (A solid round bar of that area moment would need "
            f"{round(density, -3):,.0f} kg/m^3, more than any metal has: it cannot be meant for one.)",
        ),
        Reading(
            "Table I",
            'actuator constants k_1 = 0.63, K_2 = 0.18, "N-m & N-m/rad"',
            "the torque-speed line tau <= 0.63 - 0.18 omega, in N m and N m s/rad",
            "0.63 is the stall torque of the next row and 0.18 = 0.63/3.5, stall torque over no-load speed, exactly. "
            "So they are not k_1, k_2 of eq. 20, 21: at a Coulomb level of the stall torque no motor could start",
        ),
        Reading(
            "Table I",
            "stall torque and no-load speed, which no equation uses",
            "a limit on the motor torque tau of eq. 14, 15 over rotor speed",
            "that is what such a line means; the figures show commanded and applied torque",
        ),
    )


def _missing(cases: PaperCases) -> tuple[Reading, ...]:
    numbers = cases.friction
    return (
        Reading(
            "Coulomb levels",
            "none",
            f"b^d = {numbers.dynamic:g} N m, b^s = {numbers.static:g} N m, epsilon = {numbers.epsilon:g} rad/s, chosen",
            f'{100 * numbers.dynamic / cases.limit.stall_torque:.0f} % of the stall torque: "small", as section 3 says',
        ),
        Reading(
            "rotor inertia J",
            "none",
            f"{cases.arm().J:g} kg m^2 reflected, chosen",
            "a tenth of what the shoulder turns; what depends on it is shown by a chapter of its own",
        ),
        Reading(
            "first state",
            "q_1(0) = 0, q_2(0) = 90 degrees only",
            "rotors at the links' angles, everything at rest",
            "the only state without torque in which nothing moves",
        ),
    )


def _figures() -> tuple[Reading, ...]:
    return (
        Reading(
            "Fig. 1-5",
            "lost in the copy at hand",
            f"Fig. 4 chosen: +-{AMPLITUDE:g} N m, {PULSE:g} s each, then nothing, the same at both joints",
            "so no curve of the paper could be compared, only its statements",
        ),
        Reading(
            "section 5.2",
            '"As shown in Fig. 4, the flexible joint results in a large oscillation"; "torque pattern given in Fig. 5"',
            "Fig. 3 for the oscillation, Fig. 4 for the torque",
            "the captions say so",
        ),
        Reading(
            "section 5.2",
            'Fig. 5 is said to show motion "without effect of frictional forces", with it, and with increased damping',
            "three comparisons: without and with friction at v = 0.01 (Fig. 5), and v growing",
            "one caption cannot be all three; more figures were probably numbered once",
        ),
        Reading(
            "section 5.2",
            '"compared with that of rigid links"',
            "rigid joints",
            "the links are rigid in both models",
        ),
    )
