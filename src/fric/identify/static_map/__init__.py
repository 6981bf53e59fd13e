"""The static map, eq. (2), from strokes at constant velocity."""
