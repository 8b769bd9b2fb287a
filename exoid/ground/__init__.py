"""Foundation of every package: errors, files, figures, HTML, lazy names, TOML tables. Knows nothing of legs."""
