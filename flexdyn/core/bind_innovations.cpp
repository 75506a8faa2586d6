#include "bindings.hpp"
#include "innovations.hpp"

namespace flexdyn {

namespace {

using Stack = Read<double, nb::ndim<4>>;
using Table = Read<double, nb::ndim<3>>;
using OutStack = Written<double, nb::ndim<4>, nb::c_contig>;
using OutTable = Written<double, nb::ndim<3>, nb::c_contig>;
using OutMatrix = Written<double, nb::ndim<2>, nb::c_contig>;

// Every length is compared by itself: a product of lengths may overflow where one of them is 0.
struct Sizes {
  std::size_t windows, blocks, channels, nx;
  Sizes(const Stack& flow, const Stack& seen)
      : windows(seen.shape(0)), blocks(seen.shape(1)), channels(seen.shape(2)), nx(seen.shape(3)) {
    require(shaped(flow, {windows, blocks, nx, nx}), "flow is (windows, blocks, nx, nx)");
  }
  bool empty() const { return windows == 0 || blocks == 0 || channels == 0; }
  template <typename Any>
  bool channelled(const Any& array) const {
    return shaped(array, {windows, blocks, channels});
  }
  template <typename Any>
  bool gained(const Any& gain, const Any& first_gain, const Any& whitener) const {
    return shaped(gain, {windows, blocks, nx, channels}) && shaped(first_gain, {windows, blocks, nx, channels}) &&
           shaped(whitener, {windows, blocks, channels, channels});
  }
  std::size_t row(std::size_t w) const { return w * blocks * channels; }
  WindowResponse of(std::size_t w, const Stack& flow, const double* push, const Stack& seen, const double* counted,
                    const double* sensor, double limit) const {
    const std::size_t square = w * blocks * nx * nx;
    return {blocks, nx, channels, flow.data() + square, push ? push + square : nullptr, seen.data() + row(w) * nx,
            counted + row(w), sensor ? sensor + row(w) : nullptr, limit};
  }
};

void gains(Stack flow, Stack push, Stack seen, Table counted, Table sensor, Table prior, double limit, OutStack gain,
           OutStack first_gain, OutStack whitener, OutTable carried, OutTable doubt) {
  const Sizes all(flow, seen);
  const std::size_t nx = all.nx, many = all.channels;
  require(shaped(push, {all.windows, all.blocks, nx, nx}) && all.channelled(counted) && all.channelled(sensor) &&
              shaped(prior, {all.windows, nx, nx}),
          "windows differ in shape");
  require(all.gained(gain, first_gain, whitener) && all.channelled(carried) && all.channelled(doubt),
          "arrays of other windows");
  if (all.empty()) return;
  nb::gil_scoped_release release;
  for (std::size_t w = 0; w < all.windows; ++w) {
    const std::size_t row = all.row(w);
    window_gains(all.of(w, flow, push.data(), seen, counted.data(), sensor.data(), limit), prior.data() + w * nx * nx,
                 {gain.data() + row * nx, first_gain.data() + row * nx, whitener.data() + row * many,
                  carried.data() + row, doubt.data() + row});
  }
}

void innovations(Stack flow, Stack seen, Table counted, double limit, Stack gain, Stack first_gain, Stack whitener,
                 Table mean, OutMatrix first, OutTable white) {
  const Sizes all(flow, seen);
  const std::size_t nx = all.nx, many = all.channels;
  require(all.channelled(counted) && all.gained(gain, first_gain, whitener) && all.channelled(mean) &&
              shaped(first, {all.windows, nx}) && all.channelled(white),
          "arrays of other windows");
  if (all.empty()) return;
  nb::gil_scoped_release release;
  for (std::size_t w = 0; w < all.windows; ++w) {
    const std::size_t row = all.row(w);
    const KnownGains known{gain.data() + row * nx, first_gain.data() + row * nx, whitener.data() + row * many};
    window_innovations(all.of(w, flow, nullptr, seen, counted.data(), nullptr, limit), known, mean.data() + row,
                       first.data() + w * nx, white.data() + row);
  }
}

}  // namespace

void bind_innovations(nb::module_& m) {
  m.def("window_gains", &gains, nb::arg("flow"), nb::arg("push"), nb::arg("seen"), nb::arg("counted"),
        nb::arg("sensor"), nb::arg("prior"), nb::arg("limit"), nb::arg("gain"), nb::arg("first_gain"),
        nb::arg("whitener"), nb::arg("carried"), nb::arg("doubt"));
  m.def("window_innovations", &innovations, nb::arg("flow"), nb::arg("seen"), nb::arg("counted"), nb::arg("limit"),
        nb::arg("gain"), nb::arg("first_gain"), nb::arg("whitener"), nb::arg("mean"), nb::arg("first"),
        nb::arg("white"));
}

}  // namespace flexdyn
