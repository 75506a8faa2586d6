#include "bindings.hpp"
#include "innovations.hpp"

namespace flexdyn {

namespace {

using Stack = nb::ndarray<const double, nb::ndim<4>, nb::c_contig, nb::device::cpu>;
using Table = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

struct Sizes {
  std::size_t windows, blocks, channels, nx;
  Sizes(const Stack& flow, const Stack& seen)
      : windows(seen.shape(0)), blocks(seen.shape(1)), channels(seen.shape(2)), nx(seen.shape(3)) {
    require(flow.size() == windows * blocks * nx * nx && flow.shape(3) == nx, "flow is (windows, blocks, nx, nx)");
  }
  std::size_t rows() const { return windows * blocks * channels; }
  WindowResponse of(std::size_t w, const Stack& flow, const double* push, const Stack& seen, const double* counted,
                    const double* sensor, double limit) const {
    const std::size_t square = w * blocks * nx * nx, row = w * blocks * channels;
    return {blocks, nx, channels, flow.data() + square, push ? push + square : nullptr, seen.data() + row * nx,
            counted + row, sensor ? sensor + row : nullptr, limit};
  }
};

void gains(Stack flow, Stack push, Stack seen, Table counted, Table sensor, Matrix std, double limit, OutArray gain,
           OutArray first_gain, OutArray whitener, OutArray carried, OutArray doubt) {
  const Sizes all(flow, seen);
  const std::size_t rows = all.rows(), nx = all.nx, many = all.channels;
  require(push.size() == flow.size() && counted.size() == rows && sensor.size() == rows, "windows differ in shape");
  require(std.size() == all.windows * nx && gain.size() == rows * nx && first_gain.size() == rows * nx &&
              whitener.size() == rows * many && carried.size() == rows && doubt.size() == rows,
          "arrays of other windows");
  nb::gil_scoped_release release;
  for (std::size_t w = 0; w < all.windows; ++w) {
    const std::size_t row = w * all.blocks * many;
    window_gains(all.of(w, flow, push.data(), seen, counted.data(), sensor.data(), limit), std.data() + w * nx,
                 {gain.data() + row * nx, first_gain.data() + row * nx, whitener.data() + row * many,
                  carried.data() + row, doubt.data() + row});
  }
}

void innovations(Stack flow, Stack seen, Table counted, double limit, OutArray gain, OutArray first_gain,
                 OutArray whitener, Table mean, OutArray first, OutArray white) {
  const Sizes all(flow, seen);
  const std::size_t rows = all.rows(), nx = all.nx, many = all.channels;
  require(counted.size() == rows && gain.size() == rows * nx && first_gain.size() == rows * nx &&
              whitener.size() == rows * many && mean.size() == rows && first.size() == all.windows * nx &&
              white.size() == rows,
          "arrays of other windows");
  nb::gil_scoped_release release;
  for (std::size_t w = 0; w < all.windows; ++w) {
    const std::size_t row = w * all.blocks * many;
    const WindowGains known{gain.data() + row * nx, first_gain.data() + row * nx, whitener.data() + row * many, nullptr,
                            nullptr};
    window_innovations(all.of(w, flow, nullptr, seen, counted.data(), nullptr, limit), known, mean.data() + row,
                       first.data() + w * nx, white.data() + row);
  }
}

}  // namespace

void bind_innovations(nb::module_& m) {
  m.def("window_gains", &gains, nb::arg("flow"), nb::arg("push"), nb::arg("seen"), nb::arg("counted"),
        nb::arg("sensor"), nb::arg("std"), nb::arg("limit"), nb::arg("gain"), nb::arg("first_gain"),
        nb::arg("whitener"), nb::arg("carried"), nb::arg("doubt"));
  m.def("window_innovations", &innovations, nb::arg("flow"), nb::arg("seen"), nb::arg("counted"), nb::arg("limit"),
        nb::arg("gain"), nb::arg("first_gain"), nb::arg("whitener"), nb::arg("mean"), nb::arg("first"),
        nb::arg("white"));
}

}  // namespace flexdyn
