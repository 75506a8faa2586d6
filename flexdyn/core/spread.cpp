#include "spread.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace flexdyn {

namespace {

struct Stopped : std::runtime_error {
  Stopped() : std::runtime_error("stopped") {}
};

}  // namespace

void spread(std::size_t count, int threads, const nb::object& progress,
            const std::function<void(std::size_t run, const Poll& poll)>& work) {
  std::atomic<std::size_t> next{0}, done{0};
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::condition_variable woken;
  int working = std::max(1, std::min(threads, static_cast<int>(count)));
  const Poll poll = [&stop](double) {
    if (stop) throw Stopped();
  };
  const auto thread = [&] {
    for (std::size_t i = next++; i < count && !stop; i = next++) {
      work(i, poll);
      ++done;
    }
    const std::lock_guard<std::mutex> lock(mutex);
    if (--working == 0) woken.notify_one();
  };
  std::exception_ptr interrupted;
  {
    nb::gil_scoped_release release;
    std::vector<std::thread> pool;
    for (int k = working; k > 0; --k) pool.emplace_back(thread);
    std::unique_lock<std::mutex> lock(mutex);
    while (!woken.wait_for(lock, std::chrono::milliseconds(100), [&working] { return working == 0; })) {
      if (stop) continue;
      lock.unlock();
      {
        nb::gil_scoped_acquire gil;
        try {
          if (PyErr_CheckSignals() != 0) throw nb::python_error();
          if (!progress.is_none()) progress(done.load());
        } catch (...) {
          interrupted = std::current_exception();
          stop = true;
        }
      }
      lock.lock();
    }
    lock.unlock();
    for (std::thread& each : pool) each.join();
  }
  if (interrupted) std::rethrow_exception(interrupted);
}

}  // namespace flexdyn
