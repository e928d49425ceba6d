"""What the tabs draw, as arrays from the laws."""
