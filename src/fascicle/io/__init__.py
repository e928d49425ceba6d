"""Files and text from outside: whole files on disk, input files, TOML, printable lines."""
