"""Recordings prepared once, and everything that is then asked of them: the session behind page and notebook."""
