"""The paper, made again: what it prints, its experiments, and one file per figure, table and equation."""
