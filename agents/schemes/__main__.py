"""`python -m agents.schemes`."""

from __future__ import annotations

import sys

from agents.command import exit_status
from agents.schemes.command import main

if __name__ == "__main__":
    sys.exit(exit_status(main))
