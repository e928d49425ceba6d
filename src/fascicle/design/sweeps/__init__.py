"""A search on many workers, that can be stopped and resumed."""
