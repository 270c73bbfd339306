"""Other people's programs on our environments, unmodified: tried at every new release of theirs.

Marked slow; each is skipped where its program is not installed. `requirements.txt` says how to
run them in an environment of their own.
"""
