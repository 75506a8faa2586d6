#include "bindings.hpp"

NB_MODULE(_core, m) {
  m.doc() = "flexdyn's compiled core: plant, laws, steppers and the march that integrates.";
  flexdyn::bind_plant(m);
  flexdyn::bind_simulate(m);
}
