"""From a file to a recording, without a step back: format, columns, units, clock, repair."""
