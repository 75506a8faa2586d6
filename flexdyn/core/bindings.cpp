#include "bindings.hpp"

NB_MODULE(_core, m) {
  // A kept traceback ties the interpreter's last objects to ours: nothing that a user could or should act on.
  nb::set_leak_warnings(false);
  m.doc() = "flexdyn's compiled core: plant, laws, steppers and the march that integrates.";
  flexdyn::bind_links(m);
  flexdyn::bind_plant(m);
  flexdyn::bind_kinematics(m);
  flexdyn::bind_simulate(m);
  flexdyn::bind_pack(m);
  flexdyn::bind_rows(m);
  flexdyn::bind_innovations(m);
}
