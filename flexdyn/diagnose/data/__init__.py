"""Recordings for the diagnosis: on a uniform clock, filtered, with sensor errors removed."""
