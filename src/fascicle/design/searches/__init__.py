"""Ways to find the best of a space, and how sure that is."""
