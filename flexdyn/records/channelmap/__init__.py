"""Channel maps: how the columns of a log become channels in SI units."""
