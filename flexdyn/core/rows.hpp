// Rows of the equations of motion: filtered, decimated, and made white by a banded Cholesky factor.
#pragma once

#include <cstddef>
#include <cstdint>

namespace flexdyn {

// out[r] = sum_m taps[m] x[r * every + m] for columns of x (samples, columns); out is (rows, columns).
void filter_rows(const double* x, std::size_t columns, const double* taps, std::size_t count, std::size_t every,
                 std::size_t rows, double* out);

// The lower Cholesky factor L of a banded covariance, row by row: factor[i * width + d] = L(i, i - d), and zero before
// the first column; masked rows become zero.
struct BandFactor {
  const double* factor;
  std::size_t rows, width;
  const unsigned char* masked;  // not 0: yes; a bool of another program may be any byte
};

// Such a factor of one column by column, as LAPACK has it: band[j * width + d] = L(j + d, j).
void by_rows(const double* band, std::size_t rows, std::size_t width, double* factor);

// Adds the covariance of rows from noise: band[(t * many + b) * width + lag * many + a - b] is that of row a of `many`
// equations, `lag` times after t, with row b at t. Term k has the coefficients terms[(t * count + k) * many + row];
// weights[(lag * count + k) * count + m] is the covariance of the noise in term k, `lag` times later, with that in term m.
void noise_band(const double* terms, std::size_t times, std::size_t count, std::size_t many, const double* weights,
                std::size_t lags, double* band, std::size_t width);

// L^-1 of many columns, each contiguous (columns, rows).
void whiten(const BandFactor& band, const double* raw, std::size_t columns, double* white);

// The same in single precision, the equations apart: rows of `many` equations alternate in `raw`; white is
// (many, columns, rows / many), an equation `apart` numbers after the one before, or before it if that is negative.
void whiten_apart(const BandFactor& band, const double* raw, std::size_t columns, std::size_t many, float* white,
                  std::ptrdiff_t apart);

// out[i * others + k] = one[which[i]] . other[k] of rows in single and in double precision, `rows` numbers each.
void mixed_products(const float* one, const std::int64_t* which, std::size_t columns, const double* other,
                    std::size_t others, std::size_t rows, double* out);

}  // namespace flexdyn
