"""Labelled values for Python, command line and explorer alike, and their way out."""
