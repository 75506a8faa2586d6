"""Batch studies."""
