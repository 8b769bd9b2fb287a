"""One file per item of the paper, called after its kind and its numbers (or its subject, where it has no number).

Each defines `TITLE`, `SAYS`, what the paper says in a sentence, and `answer(experiments)`, which returns an
`ItemAnswer`. The folder is read; nothing is registered.
"""
