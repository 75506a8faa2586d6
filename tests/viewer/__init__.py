"""The viewer: what it shows is what the arm did, and the page is sound in a real browser."""
