"""Control design by margins, and the limit of the Q-filter."""
