"""Processing of recordings: trimming, resampling, smoothing, differentiating, estimating noise."""
