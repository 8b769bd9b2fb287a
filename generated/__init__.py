"""The C code of the standard leg, written by `exoid generate`; never edited by hand."""
