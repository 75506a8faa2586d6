"""Hypotheses about a robot (numbers of its file and missing effects), and their fits to the equations."""
