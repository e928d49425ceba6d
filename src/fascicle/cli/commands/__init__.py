"""A command a module: its options, and what it calls and prints."""
