"""How far two motions are apart.

`motion_sources` brings runs, recordings and files of them to one form, `difference` takes two of them at common times,
and `compare` gives the errors of every channel.
"""
