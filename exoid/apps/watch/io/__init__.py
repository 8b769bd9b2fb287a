"""What `exoid watch` is around a watcher: where samples come from, and where events go."""
