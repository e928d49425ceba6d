"""What each design does, and how good that is."""
