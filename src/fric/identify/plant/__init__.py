"""The plant, eq. (1), from frequency responses or from an ordinary motion."""
