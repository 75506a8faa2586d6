"""Pictures of motions and frequencies in both renderers, and the pages in a real browser."""
