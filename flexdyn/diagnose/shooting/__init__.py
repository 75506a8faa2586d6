"""Short windows, simulated in open loop from fitted first states: the gap."""
