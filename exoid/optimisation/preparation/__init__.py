"""From recordings to samples that a fit may use: cut-off, filtering, outliers."""
