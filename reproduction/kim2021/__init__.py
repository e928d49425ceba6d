"""Kim, Mazzoleni and Bryant (2021): a module a figure, and the report of them all."""
