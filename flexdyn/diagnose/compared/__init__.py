"""Several models of one arm side by side: which numbers moved, which stayed, which effects came or went."""
