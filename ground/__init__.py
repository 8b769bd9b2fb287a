"""What every package stands on: errors, files, figures, HTML, lazy names, TOML tables. Knows nothing of legs."""

from exoid.ground.lazy import only_inside

only_inside(__name__)
