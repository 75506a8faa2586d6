"""Errors between two motions.

`motion_sources` converts runs, recordings and files to one form, `difference` evaluates two of them at common times,
and `compare` gives the errors of every channel.
"""
