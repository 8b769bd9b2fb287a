"""Hypotheses of what may be the matter other than a missing effect: a file each, found by reading the folder of its
kind.

`recordings`: something belongs to recordings, a zero or a load of their own. `readings`: channels or geometry are
not what they are read as; searched as effects are. `channels`: channels cannot be what they say.
"""
