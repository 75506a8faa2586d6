"""What is done to the samples of a recording: cut, resampled, smoothed, differentiated, their noise estimated."""
