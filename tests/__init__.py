"""The tests; a package, so that another distribution that installs a module `tests` is not taken for it."""
