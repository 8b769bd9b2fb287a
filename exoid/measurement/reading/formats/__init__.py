"""One file per format: SUFFIXES, SIGNATURES and `read(path) -> RawTable`; nothing to register."""
