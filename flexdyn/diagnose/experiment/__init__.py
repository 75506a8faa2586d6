"""Motions that would separate rivals, tested by simulation."""
