"""Commands and servos as data, checked before anything is simulated."""
