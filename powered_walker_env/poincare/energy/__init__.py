"""What walking costs, and what the contacts must bear."""
