"""The workbench in the browser: a local server (`app`), what is open in it (`workspace`), and its page (`static/`)."""
