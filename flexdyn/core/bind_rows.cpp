#include "bindings.hpp"
#include "rows.hpp"

namespace flexdyn {

namespace {

using Flags = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Singles = nb::ndarray<float, nb::ndim<3>, nb::device::cpu>;

void filtered(Matrix x, Array taps, std::size_t every, OutArray out) {
  const std::size_t columns = x.shape(1), rows = columns ? out.size() / columns : 0;
  require(every > 0 && taps.size() > 0 && rows * columns == out.size(), "rows of all columns");
  require(rows == 0 || (rows - 1) * every + taps.size() <= x.shape(0), "a sample for every tap");
  nb::gil_scoped_release release;
  filter_rows(x.data(), columns, taps.data(), taps.size(), every, rows, out.data());
}

BandFactor checked(const Matrix& factor, const Flags& masked, const Matrix& raw) {
  const BandFactor band{factor.data(), factor.shape(0), factor.shape(1), masked.data()};
  require(band.width > 0 && masked.size() == band.rows && raw.shape(1) == band.rows, "rows differ in number");
  return band;
}

void banded(Matrix band, OutArray factor) {
  require(factor.size() == band.size(), "as many numbers as the band has");
  nb::gil_scoped_release release;
  by_rows(band.data(), band.shape(0), band.shape(1), factor.data());
}

void white(Matrix factor, Flags masked, Matrix raw, OutArray out) {
  const BandFactor band = checked(factor, masked, raw);
  require(out.size() == raw.size(), "as many white rows as raw ones");
  nb::gil_scoped_release release;
  whiten(band, raw.data(), raw.shape(0), out.data());
}

void white_apart(Matrix factor, Flags masked, Matrix raw, Singles out) {
  const BandFactor band = checked(factor, masked, raw);
  const std::size_t many = out.shape(0), times = out.shape(2);
  require(out.size() == raw.size() && out.shape(1) == raw.shape(0), "as many white rows as raw ones");
  require(out.size() == 0 || (out.stride(2) == 1 && out.stride(1) == static_cast<std::int64_t>(times)),
          "the columns of an equation are contiguous");
  nb::gil_scoped_release release;
  whiten_apart(band, raw.data(), raw.shape(0), many, out.data(), static_cast<std::size_t>(out.stride(0)));
}

void products(nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu> one,
              nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> which, Matrix other,
              OutArray out) {
  const std::size_t rows = one.shape(1);
  require(other.shape(1) == rows && out.size() == which.size() * other.shape(0), "rows differ in number");
  for (std::size_t i = 0; i < which.size(); ++i) {
    require(which.data()[i] >= 0 && static_cast<std::size_t>(which.data()[i]) < one.shape(0), "no such column");
  }
  nb::gil_scoped_release release;
  mixed_products(one.data(), which.data(), which.size(), other.data(), other.shape(0), rows, out.data());
}

}  // namespace

void bind_rows(nb::module_& m) {
  m.def("filter_rows", &filtered, nb::arg("x"), nb::arg("taps"), nb::arg("every"), nb::arg("out"));
  m.def("mixed_products", &products, nb::arg("one"), nb::arg("which"), nb::arg("other"), nb::arg("out"));
  m.def("by_rows", &banded, nb::arg("band"), nb::arg("factor"));
  m.def("whiten", &white, nb::arg("factor"), nb::arg("masked"), nb::arg("raw"), nb::arg("out"));
  m.def("whiten_apart", &white_apart, nb::arg("factor"), nb::arg("masked"), nb::arg("raw"), nb::arg("out"));
}

}  // namespace flexdyn
