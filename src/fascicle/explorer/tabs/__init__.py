"""The tabs: what each shows, and what can be chosen on it."""
