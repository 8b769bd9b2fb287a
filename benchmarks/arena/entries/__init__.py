"""Who is asked: a file of at most 40 lines each, with TITLE and `answer(task)`; the folder is read."""
