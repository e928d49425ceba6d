"""Words of findings, tables for the terminal, and self-contained HTML pages."""
