"""The model and its file: what is accepted, what is refused and why, and what reads back without loss."""
