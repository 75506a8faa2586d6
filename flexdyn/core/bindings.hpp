// What the binding files share: array types and how a Python callable becomes a law.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <vector>

namespace nb = nanobind;

namespace flexdyn {

// An array that is read: one of another kind or order is converted, one whose numbers are not aligned is copied.
template <typename T, typename... Form>
struct Read : nb::ndarray<const T, Form..., nb::c_contig, nb::device::cpu> {
  using Base = nb::ndarray<const T, Form..., nb::c_contig, nb::device::cpu>;
  static constexpr bool written = false;
  Read() = default;
  explicit Read(const Base& array) : Base(array) {}
};

// An array that is written: it must be of the right kind as it is, because a converted copy would take the results.
template <typename T, typename... Form>
struct Written : nb::ndarray<T, Form..., nb::device::cpu> {
  using Base = nb::ndarray<T, Form..., nb::device::cpu>;
  static constexpr bool written = true;
  Written() = default;
  explicit Written(const Base& array) : Base(array) {}
};

using Array = Read<double>;
using Matrix = Read<double, nb::ndim<2>>;
using OutArray = Written<double, nb::c_contig>;

inline std::vector<double> to_vector(const Array& array) {
  return std::vector<double>(array.data(), array.data() + array.size());
}

// Shapes are checked where arrays cross the border, so that inner loops can assume them.
inline void require(bool condition, const char* what) {
  if (!condition) throw std::invalid_argument(what);
}

template <typename Any>
bool shaped(const Any& array, std::initializer_list<std::size_t> shape) {
  if (array.ndim() != shape.size()) return false;
  std::size_t axis = 0;
  for (const std::size_t length : shape) {
    if (array.shape(axis++) != length) return false;
  }
  return true;
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

namespace nanobind::detail {

template <typename Kind, typename T>
struct array_caster {
  NB_TYPE_CASTER(Kind, make_caster<typename Kind::Base>::Name)

  bool from_python(handle src, std::uint32_t flags, cleanup_list* cleanup) noexcept {
    if constexpr (Kind::written) flags &= ~static_cast<std::uint32_t>(cast_flags::convert);
    if (!take(src, flags, cleanup)) return false;
    if (aligned()) return true;
    if (Kind::written || !(flags & static_cast<std::uint32_t>(cast_flags::convert))) return false;
    try {
      return take(module_::import_("numpy").attr("array")(src), flags, cleanup) && aligned();
    } catch (python_error&) {
      return false;
    }
  }

 private:
  bool take(handle src, std::uint32_t flags, cleanup_list* cleanup) noexcept {
    make_caster<typename Kind::Base> array;
    if (!array.from_python(src, flags, cleanup)) return false;
    value = Kind(array.value);
    return true;
  }
  bool aligned() const { return reinterpret_cast<std::uintptr_t>(value.data()) % alignof(T) == 0; }
};

template <typename T, typename... Form>
struct type_caster<flexdyn::Read<T, Form...>> : array_caster<flexdyn::Read<T, Form...>, T> {};
template <typename T, typename... Form>
struct type_caster<flexdyn::Written<T, Form...>> : array_caster<flexdyn::Written<T, Form...>, T> {};

}  // namespace nanobind::detail
