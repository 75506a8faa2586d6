"""Motions that would tell names apart, tried by simulation."""
