"""Errors between two motions."""
