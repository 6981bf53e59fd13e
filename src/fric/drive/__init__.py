"""Plant, sensing and the cascade controller of one axis."""
