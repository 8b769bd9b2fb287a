"""The next experiment: how far apart rival effects are, why some cannot be distinguished, and the motion that does."""
