#include "bindings.hpp"
#include "rows.hpp"

namespace flexdyn {

namespace {

using Flags = Read<bool, nb::ndim<1>>;
using Singles = Written<float, nb::ndim<3>>;
using Table = Written<double, nb::ndim<2>, nb::c_contig>;

void filtered(Matrix x, Array taps, std::size_t every, Table out) {
  const std::size_t samples = x.shape(0), columns = x.shape(1), rows = out.shape(0), count = taps.size();
  require(every > 0 && count > 0 && out.shape(1) == columns, "out is (rows, columns), every and the taps are not 0");
  // Divided, because a product of sizes from outside may overflow.
  require(rows == 0 || (count <= samples && rows - 1 <= (samples - count) / every), "a sample for every tap");
  if (columns == 0) return;
  nb::gil_scoped_release release;
  filter_rows(x.data(), columns, taps.data(), count, every, rows, out.data());
}

BandFactor checked(const Matrix& factor, const Flags& masked, const Matrix& raw) {
  const std::size_t rows = factor.shape(0), width = factor.shape(1);
  require(masked.size() == rows && raw.shape(1) == rows, "rows differ in number");
  require(rows == 0 || (width > 0 && width <= rows), "a band is as wide as the rows at most");
  return {factor.data(), rows, width, reinterpret_cast<const unsigned char*>(masked.data())};
}

void banded(Matrix band, Table factor) {
  require(shaped(factor, {band.shape(0), band.shape(1)}), "the factor has the shape of the band");
  nb::gil_scoped_release release;
  by_rows(band.data(), band.shape(0), band.shape(1), factor.data());
}

void covariance(Read<double, nb::ndim<3>> terms, Read<double, nb::ndim<3>> weights, Table band) {
  const std::size_t times = terms.shape(0), count = terms.shape(1), many = terms.shape(2), lags = weights.shape(0);
  require(shaped(weights, {lags, count, count}) && lags > 0, "weights are (lags, terms, terms)");
  require(band.shape(0) == times * many && lags * many <= band.shape(1), "a row for every equation and time");
  if (terms.size() == 0 || band.size() == 0) return;
  nb::gil_scoped_release release;
  noise_band(terms.data(), times, count, many, weights.data(), lags, band.data(), band.shape(1));
}

void white(Matrix factor, Flags masked, Matrix raw, Table out) {
  const BandFactor band = checked(factor, masked, raw);
  require(shaped(out, {raw.shape(0), band.rows}), "as many white rows as raw ones");
  nb::gil_scoped_release release;
  whiten(band, raw.data(), raw.shape(0), out.data());
}

void white_apart(Matrix factor, Flags masked, Matrix raw, Singles out) {
  const BandFactor band = checked(factor, masked, raw);
  const std::size_t many = out.shape(0), columns = raw.shape(0);
  require(many > 0 && shaped(out, {many, columns, band.rows / many}) && band.rows % many == 0,
          "white is (equations, columns, times)");
  if (out.size() == 0) return;
  require(out.stride(2) == 1 && out.stride(1) == static_cast<std::int64_t>(out.shape(2)),
          "the columns of an equation are contiguous");
  nb::gil_scoped_release release;
  whiten_apart(band, raw.data(), columns, many, out.data(), static_cast<std::ptrdiff_t>(out.stride(0)));
}

void products(Read<float, nb::ndim<2>> one, Read<std::int64_t, nb::ndim<1>> which, Matrix other, Table out) {
  const std::size_t rows = one.shape(1), columns = which.size(), others = other.shape(0);
  require(other.shape(1) == rows && shaped(out, {columns, others}), "rows differ in number");
  for (std::size_t i = 0; i < columns; ++i) {
    require(which.data()[i] >= 0 && static_cast<std::size_t>(which.data()[i]) < one.shape(0), "no such column");
  }
  if (out.size() == 0) return;
  nb::gil_scoped_release release;
  mixed_products(one.data(), which.data(), columns, other.data(), others, rows, out.data());
}

}  // namespace

void bind_rows(nb::module_& m) {
  m.def("filter_rows", &filtered, nb::arg("x"), nb::arg("taps"), nb::arg("every"), nb::arg("out"));
  m.def("mixed_products", &products, nb::arg("one"), nb::arg("which"), nb::arg("other"), nb::arg("out"));
  m.def("noise_band", &covariance, nb::arg("terms"), nb::arg("weights"), nb::arg("band"));
  m.def("by_rows", &banded, nb::arg("band"), nb::arg("factor"));
  m.def("whiten", &white, nb::arg("factor"), nb::arg("masked"), nb::arg("raw"), nb::arg("out"));
  m.def("whiten_apart", &white_apart, nb::arg("factor"), nb::arg("masked"), nb::arg("raw"), nb::arg("out"));
}

}  // namespace flexdyn
