// A Kalman filter on the linear response of simulated windows to their first states and to the noise of torques.
#pragma once

#include <cstddef>

namespace flexdyn {

// One window: blocks of samples, nx states, channels. Matrices are row by row, one for each block.
struct WindowResponse {
  std::size_t blocks, nx, channels;
  const double* flow;     // transition to the middle of each block (nx, nx)
  const double* push;     // covariance that the torque noise adds in between (nx, nx)
  const double* seen;     // derivative of the channels by the state (channels, nx)
  const double* counted;  // 1 for a channel that was measured in a block, else 0 (channels)
  const double* sensor;   // variance of a block's mean by the sensors' noise (channels)
  double limit;           // bound of covariances and states: larger ones belong to divergent motions
};

// What a filter knows before it sees a residual, for each block.
struct WindowGains {
  double* gain;        // of the state's error by innovation (nx, channels)
  double* first_gain;  // of the first state's error by innovation (nx, channels)
  double* whitener;    // inverse Cholesky factor of the innovation's covariance (channels, channels)
  double* carried;     // variance that torque noise makes of a channel from a true first state (channels)
  double* doubt;       // variance that is left of the first state's error after all blocks, in a channel (channels)
};

// Those of them that a residual needs.
struct KnownGains {
  const double *gain, *first_gain, *whitener;
};

// `prior` is the covariance of the first state (nx, nx).
void window_gains(const WindowResponse& window, const double* prior, const WindowGains& found);

// White innovations (blocks, channels) of the means of blocks (blocks, channels), and the error of the first state.
// `first` holds the error that is known beforehand (nx), and takes the estimate from all blocks.
void window_innovations(const WindowResponse& window, const KnownGains& known, const double* mean, double* first,
                        double* white);

}  // namespace flexdyn
