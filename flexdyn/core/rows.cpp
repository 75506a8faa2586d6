#include "rows.hpp"

#include <algorithm>
#include <vector>

// These loops are bound by arithmetic, and wheels are built for the oldest processors: GCC makes a version of each
// function for newer ones, and the loader takes the one that fits. Results are the same bits on one machine. GCC knows
// these levels since version 12. The loader chooses before the thread sanitizer is ready, and would end the process.
#if defined(__GNUC__) && __GNUC__ >= 12 && !defined(__clang__) && defined(__x86_64__) && defined(__linux__) && \
    !defined(__SANITIZE_THREAD__)
#define FLEXDYN_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define FLEXDYN_CLONES
#endif

namespace flexdyn {

namespace {

// Four numbers that are added and multiplied at once; loads need no alignment. That is the width of an AVX2 register:
// GCC keeps wider vectors on the stack there, which takes sixteen times as long.
constexpr std::size_t FOUR = 4;
typedef double Four __attribute__((vector_size(32)));
typedef double Loose __attribute__((vector_size(32), aligned(8), may_alias));
typedef float LooseSingles __attribute__((vector_size(16), aligned(4), may_alias));

constexpr std::size_t LANES = 16, PARTS = LANES / FOUR;  // columns at once: their window stays in the first cache

inline __attribute__((always_inline)) double sum(const Four& four) {
  return (four[0] + four[2]) + (four[1] + four[3]);
}

// Forward substitution of LANES columns. The last `width` white rows stand twice in `window`, so that those before any
// row are contiguous. Even and odd places of the band are summed apart: two chains of additions instead of one.
template <typename Store>
inline __attribute__((always_inline)) void substitute(const BandFactor& band, const double* const* raw, double* window,
                                                      const Store& store) {
  const std::size_t width = band.width;
  for (std::size_t i = 0; i < band.rows; ++i) {
    double row[LANES];
    for (std::size_t c = 0; c < LANES; ++c) row[c] = raw[c][i];
    Four even[PARTS], odd[PARTS] = {};
    for (std::size_t p = 0; p < PARTS; ++p) even[p] = reinterpret_cast<const Loose*>(row)[p];
    const std::size_t place = i % width;
    const double* factor = band.factor + i * width;
    const double* before = window + (place + width - 1) * LANES;
    std::size_t d = 1;
    for (; d + 1 < width; d += 2, before -= 2 * LANES) {
      for (std::size_t p = 0; p < PARTS; ++p) {
        even[p] -= factor[d] * reinterpret_cast<const Loose*>(before)[p];
        odd[p] -= factor[d + 1] * reinterpret_cast<const Loose*>(before - LANES)[p];
      }
    }
    for (std::size_t p = 0; d < width && p < PARTS; ++p) {
      even[p] -= factor[d] * reinterpret_cast<const Loose*>(before)[p];
    }
    const double scale = 1.0 / factor[0];
    double* here = window + place * LANES;
    for (double* at : {here, here + width * LANES}) {
      for (std::size_t p = 0; p < PARTS; ++p) reinterpret_cast<Loose*>(at)[p] = (even[p] + odd[p]) * scale;
    }
    store(i, here);
  }
}

FLEXDYN_CLONES void batch(const BandFactor& band, const double* const* raw, double* window, std::size_t count,
                          double* white) {
  substitute(band, raw, window, [&](std::size_t i, const double* row) {
    for (std::size_t c = 0; c < count; ++c) white[c * band.rows + i] = band.masked[i] ? 0.0 : row[c];
  });
}

FLEXDYN_CLONES void batch_apart(const BandFactor& band, const double* const* raw, double* window, std::size_t count,
                                std::size_t many, float* white, std::ptrdiff_t apart) {
  const std::size_t times = band.rows / many;
  substitute(band, raw, window, [&](std::size_t i, const double* row) {
    float* at = white + static_cast<std::ptrdiff_t>(i % many) * apart + i / many;
    for (std::size_t c = 0; c < count; ++c) at[c * times] = band.masked[i] ? 0.0F : static_cast<float>(row[c]);
  });
}

// Batches of columns; the last one is filled up with its own first column.
template <typename Work>
void in_batches(const BandFactor& band, const double* raw, std::size_t columns, const Work& work) {
  if (band.rows == 0) return;
  std::vector<double> window(2 * band.width * LANES);
  const double* pointers[LANES];
  for (std::size_t first = 0; first < columns; first += LANES) {
    std::fill(window.begin(), window.end(), 0.0);
    const std::size_t count = std::min(LANES, columns - first);
    for (std::size_t c = 0; c < LANES; ++c) pointers[c] = raw + (first + (c < count ? c : 0)) * band.rows;
    work(pointers, window.data(), first, count);
  }
}

}  // namespace

FLEXDYN_CLONES void filter_rows(const double* x, std::size_t columns, const double* taps, std::size_t count,
                                std::size_t every, std::size_t rows, double* out) {
  const double* end = rows ? x + ((rows - 1) * every + count) * columns : x;
  for (std::size_t r = 0; r < rows; ++r) {
    const double* from = x + r * every * columns;
    if (columns == 1) {
      Four one = {}, two = {};
      std::size_t m = 0;
      for (; m + 2 * FOUR <= count; m += 2 * FOUR) {
        one += *reinterpret_cast<const Loose*>(taps + m) * *reinterpret_cast<const Loose*>(from + m);
        two += *reinterpret_cast<const Loose*>(taps + m + FOUR) * *reinterpret_cast<const Loose*>(from + m + FOUR);
      }
      double rest = 0.0;
      for (; m < count; ++m) rest += taps[m] * from[m];
      out[r] = rest + sum(one + two);
      continue;
    }
    for (std::size_t first = 0; first < columns; first += FOUR) {
      const std::size_t some = std::min(FOUR, columns - first);
      const double* at = from + first;
      Four one = {}, two = {};
      std::size_t m = 0;
      if (at + (count - 1) * columns + FOUR <= end) {  // columns beyond the last one are added too, and not used
        for (; m + 2 <= count; m += 2) {
          one += taps[m] * *reinterpret_cast<const Loose*>(at + m * columns);
          two += taps[m + 1] * *reinterpret_cast<const Loose*>(at + (m + 1) * columns);
        }
      }
      for (; m < count; ++m) {
        for (std::size_t k = 0; k < some; ++k) one[k] += taps[m] * at[m * columns + k];
      }
      one += two;
      for (std::size_t k = 0; k < some; ++k) out[r * columns + first + k] = one[k];
    }
  }
}

FLEXDYN_CLONES void noise_band(const double* terms, std::size_t times, std::size_t count, std::size_t many,
                               const double* weights, std::size_t lags, double* band, std::size_t width) {
  std::vector<std::size_t> beside, ends;  // the terms that each one has a covariance with, lag by lag: few
  for (std::size_t place = 0; place < lags * count; ++place) {
    for (std::size_t m = 0; m < count; ++m) {
      if (weights[place * count + m] != 0.0) beside.push_back(m);
    }
    ends.push_back(beside.size());
  }
  std::vector<double> seen(many);
  for (std::size_t t = 0; t < times; ++t) {
    const double* now = terms + t * count * many;
    for (std::size_t place = 0, each = 0; place < std::min(lags, times - t) * count; ++place) {
      if (each == ends[place]) continue;
      std::fill(seen.begin(), seen.end(), 0.0);
      for (; each < ends[place]; ++each) {
        const double weight = weights[place * count + beside[each]];
        const double* own = now + beside[each] * many;
        for (std::size_t b = 0; b < many; ++b) seen[b] += weight * own[b];
      }
      const std::size_t lag = place / count;
      const double* later = now + (lag * count + place % count) * many;
      for (std::size_t b = 0; b < many; ++b) {
        if (seen[b] == 0.0) continue;
        double* row = band + (t * many + b) * width + lag * many - b;
        for (std::size_t a = lag ? 0 : b; a < many; ++a) row[a] += later[a] * seen[b];
      }
    }
  }
}

FLEXDYN_CLONES void mixed_products(const float* one, const std::int64_t* which, std::size_t columns,
                                   const double* other, std::size_t others, std::size_t rows, double* out) {
  for (std::size_t i = 0; i < columns; ++i) {
    const float* mine = one + static_cast<std::size_t>(which[i]) * rows;
    for (std::size_t k = 0; k < others; ++k) {
      const double* theirs = other + k * rows;
      Four even = {}, odd = {};
      std::size_t r = 0;
      for (; r + 2 * FOUR <= rows; r += 2 * FOUR) {
        even += __builtin_convertvector(*reinterpret_cast<const LooseSingles*>(mine + r), Four) *
                *reinterpret_cast<const Loose*>(theirs + r);
        odd += __builtin_convertvector(*reinterpret_cast<const LooseSingles*>(mine + r + FOUR), Four) *
               *reinterpret_cast<const Loose*>(theirs + r + FOUR);
      }
      double rest = 0.0;
      for (; r < rows; ++r) rest += static_cast<double>(mine[r]) * theirs[r];
      out[i * others + k] = rest + sum(even + odd);
    }
  }
}

void by_rows(const double* band, std::size_t rows, std::size_t width, double* factor) {
  if (width == 0) return;
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t d = 0; d < width; ++d) factor[i * width + d] = d <= i ? band[(i - d) * width + d] : 0.0;
  }
}

void whiten(const BandFactor& band, const double* raw, std::size_t columns, double* white) {
  in_batches(band, raw, columns, [&](const double* const* from, double* window, std::size_t first, std::size_t count) {
    batch(band, from, window, count, white + first * band.rows);
  });
}

void whiten_apart(const BandFactor& band, const double* raw, std::size_t columns, std::size_t many, float* white,
                  std::ptrdiff_t apart) {
  in_batches(band, raw, columns, [&](const double* const* from, double* window, std::size_t first, std::size_t count) {
    batch_apart(band, from, window, count, many, white + first * (band.rows / many), apart);
  });
}

}  // namespace flexdyn
