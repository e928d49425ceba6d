"""`python -m fascicle` is the command `fascicle`."""

from .cli import main


main()
