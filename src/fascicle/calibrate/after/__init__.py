"""What a fit found: how sure it is, and what it leaves."""
