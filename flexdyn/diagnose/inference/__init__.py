"""Which effects are there: one Gram matrix of all candidates, and a posterior over structures."""
