"""Published numbers and figures, and what comes out here."""
