"""What is fitted to a record, and how it is solved for."""
