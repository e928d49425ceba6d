"""Commands that aren't in a module of their family yet."""
