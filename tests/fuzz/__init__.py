"""Hostile inputs by the thousand: every reader, the command line and the border of the core, each in a forked process.

`scripts/fuzz.py` is the long run, `test_fuzz_run.py` a short one of the same code.
"""
