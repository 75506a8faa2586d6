"""Recordings as the diagnosis takes them: on a uniform clock, filtered, errors of sensors taken off."""
