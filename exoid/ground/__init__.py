"""What every package stands on: errors, files, figures, HTML, lazy names, TOML tables. Knows nothing of legs."""
