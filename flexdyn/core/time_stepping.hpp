// TimeStepping: a fixed step over whatever happens in it, springs and dampers implicit, sticking exact.
//
// Velocities at the end of a step, w = (v, omega), solve
//
//   (H - h F_w - h^2 F_p) w' + lambda = H w + h (F - F_w w - bias),     lambda_i in h [-L_negative, L_positive],
//
// H = diag(M(q), J), F the laws' torques and F_w, F_p their slopes: linearly implicit Euler, stable for any stiffness
// and damping. Each dry contact is in its box: inside it the velocity is 0, to the last bit; at its ends the contact
// slides. Positions follow as p' = p + h w'. Order 1.
#pragma once

#include "events.hpp"
#include "plant.hpp"
#include "steppers.hpp"

namespace flexdyn {

std::unique_ptr<Stepper> make_time_stepping(const Plant& plant, Plant::Workspace& work, Events::Torque torque,
                                            Events::External external, double step);

}  // namespace flexdyn
