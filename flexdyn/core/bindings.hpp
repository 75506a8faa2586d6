// What the binding files share: array types and how a Python callable becomes a law.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>
#include <vector>

namespace nb = nanobind;

namespace flexdyn {

using Array = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Matrix = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using OutArray = nb::ndarray<double, nb::c_contig, nb::device::cpu>;

inline std::vector<double> to_vector(const Array& array) {
  return std::vector<double>(array.data(), array.data() + array.size());
}

// Shapes are checked where arrays cross the border, so that inner loops can assume them.
inline void require(bool condition, const char* what) {
  if (!condition) throw std::invalid_argument(what);
}

// A Python object kept in C++ data that threads without the GIL may drop last.
class PythonCallable {
 public:
  explicit PythonCallable(nb::object callable) : callable_(callable.release().ptr()) {}
  ~PythonCallable() {
    nb::gil_scoped_acquire gil;
    Py_DECREF(callable_);
  }
  PythonCallable(const PythonCallable&) = delete;
  PythonCallable& operator=(const PythonCallable&) = delete;
  nb::handle get() const { return callable_; }

 private:
  PyObject* callable_;
};

void bind_links(nb::module_& m);
void bind_plant(nb::module_& m);
void bind_kinematics(nb::module_& m);
void bind_simulate(nb::module_& m);
void bind_pack(nb::module_& m);
void bind_rows(nb::module_& m);
void bind_innovations(nb::module_& m);

}  // namespace flexdyn
