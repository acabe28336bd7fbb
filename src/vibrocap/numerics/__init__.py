"""Series, event search, contact modes and the compiled loop."""
