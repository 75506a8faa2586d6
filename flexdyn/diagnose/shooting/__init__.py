"""Short windows simulated open loop from first states that suit them: the gap."""
