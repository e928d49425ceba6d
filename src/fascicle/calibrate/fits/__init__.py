"""The fit itself, and the choice among several."""
