"""Numbers that belong to recordings: those that one recording, a group of them, or a part of one has to itself.

Each of `exoid.diagnosis.hypotheses.recordings` adds columns to the prediction. Its numbers are learnt on one half of
every recording and judged on the other half, by the loss in blocks that the search for effects uses; that of a held-out
recording too, which has no other way to show its own.
"""
