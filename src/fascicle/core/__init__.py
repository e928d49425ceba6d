"""Core: array namespaces, modules, roots, validation, errors, lazy imports."""
