"""A new user's first hour, played from end to end: an own arm, logs as labs have them, a report in the browser.

`PYTHONPATH=scripts python -m first_hour` plays it and prints the commands that every step took, those that failed, and
how long; a test runs it. The user knows the arm and what was logged, and nothing of flexdyn but what its commands say.
"""
