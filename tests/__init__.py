"""Tests of flexdyn, and the independent oracles that they compare it with."""
