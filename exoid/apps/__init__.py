"""Apps: each folder brings commands of its own and can be taken away; the core and other apps import nothing of it."""
