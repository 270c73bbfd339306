"""Pictures: scenes and films of walks, charts of what the laboratory finds."""
