"""An executor of `concurrent.futures` as an engine, and processes of this machine."""
