"""What everything stands on: types, checks, limits, numbers in any array library, roots, files."""
