#include "bindings.hpp"
#include "commands.hpp"
#include "march.hpp"
#include "spread.hpp"

namespace flexdyn {

namespace {

// Runs of one arm that differ in numbers alone, a row of every array each.
struct Pack {
  std::shared_ptr<LinkDynamics> links;
  const std::vector<Law>& laws;
  const double *stiffness, *damping, *inertia;  // (runs, n)
  const double* parameters;                     // (runs, laws, max_law_parameters)
  const double* x0;                             // (runs, 2 (n + e))
};

std::unique_ptr<Plant> plant_of(const Pack& pack, std::size_t run) {
  const std::size_t n = pack.links->size(), count = pack.laws.size();
  const auto row = [&](const double* rows) { return std::vector<double>(rows + run * n, rows + (run + 1) * n); };
  std::vector<Law> laws = pack.laws;
  for (std::size_t k = 0; k < count; ++k) {
    const double* p = pack.parameters + (run * count + k) * max_law_parameters;
    std::copy(p, p + max_law_parameters, laws[k].p);
  }
  return std::make_unique<Plant>(pack.links, row(pack.stiffness), row(pack.damping), row(pack.inertia),
                                 std::vector<double>(n, 0.0), laws);
}

using Flags = Written<bool, nb::ndim<1>, nb::c_contig>;

// Each run that is wanted into its row of the seven outputs (runs, times, n); of `wanted` remain those that end well.
void simulate_pack(std::shared_ptr<LinkDynamics> links, const std::vector<Law>& laws, Array stiffness,
                       Array damping, Array inertia, Array parameters, const CommandFactory& command, Array x0,
                       double duration, const SolverSettings& solver, Array times, std::vector<OutArray> out,
                       Flags wanted, int threads, nb::object progress) {
  const std::size_t n = links->size(), runs = stiffness.size() / n, samples = times.size();
  require(stiffness.size() == runs * n && damping.size() == runs * n && inertia.size() == runs * n,
          "K, D and J are (runs, n)");
  require(parameters.size() == runs * laws.size() * max_law_parameters, "parameters are (runs, laws, 6)");
  require(wanted.size() == runs && out.size() == 7, "one flag a run, and seven output arrays");
  for (const OutArray& each : out) require(each.size() == runs * samples * n, "outputs are (runs, times, n)");
  for (const Law& law : laws) require(law.joint >= 0 && law.joint < static_cast<int>(n), "a law's joint is not there");
  const Pack pack{links, laws, stiffness.data(), damping.data(), inertia.data(), parameters.data(), x0.data()};
  const std::size_t width = runs == 0 ? 0 : x0.size() / runs;
  bool* done = wanted.data();
  spread(runs, threads, progress, [&](std::size_t run, const Poll& poll) {
    if (!done[run]) return;
    done[run] = false;
    try {
      const auto plant = plant_of(pack, run);
      const std::size_t size = plant->state_size(), internal = plant->internal_states();
      require(width + internal == size, "x0 is (runs, 2 (n + e))");
      std::vector<double> first(pack.x0 + run * width, pack.x0 + (run + 1) * width), z(samples * internal);
      first.resize(size, 0.0);  // internal states start at rest
      double* row[7];
      for (int k = 0; k < 7; ++k) row[k] = out[k].data() + run * samples * n;
      const Output output{times.data(), samples, row[0], row[1], row[2], row[3], row[4], row[5], row[6], z.data()};
      const auto made = command.make(static_cast<int>(n));
      done[run] = march(*plant, *made, {}, first, duration, solver, output, poll).failure.reason.empty();
    } catch (const std::exception&) {
      // Done one by one, the run will say why.
    }
  });
}

}  // namespace

void bind_pack(nb::module_& m) {
  m.attr("max_law_parameters") = max_law_parameters;
  m.def("simulate_pack", &simulate_pack, nb::arg("links"), nb::arg("laws"), nb::arg("stiffness"), nb::arg("damping"),
        nb::arg("rotor_inertia"), nb::arg("parameters"), nb::arg("command"), nb::arg("x0"), nb::arg("duration"),
        nb::arg("solver"), nb::arg("times"), nb::arg("out"), nb::arg("wanted"), nb::arg("threads"), nb::arg("progress").none());
}

}  // namespace flexdyn
