// Many runs over native threads, without the GIL.
#pragma once

#include <cstddef>
#include <functional>

#include "bindings.hpp"
#include "march.hpp"

namespace flexdyn {

// Do `work` for 0 to count - 1, each once; it must not throw but for what the poll it is given throws, which says that
// the others are stopped too. `progress` is called with the number done some ten times a second and may raise.
void spread(std::size_t count, int threads, const nb::object& progress,
            const std::function<void(std::size_t run, const Poll& poll)>& work);

}  // namespace flexdyn
