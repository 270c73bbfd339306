"""What walks: the walker, the phases of its stride, the ways to power it, its mechanics."""
