"""Tests of the simulator and the scoring of the hidden-effect benchmark."""
