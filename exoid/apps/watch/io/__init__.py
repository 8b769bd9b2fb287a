"""The parts of `exoid watch` around a watcher: sources of samples, and destinations of events."""
