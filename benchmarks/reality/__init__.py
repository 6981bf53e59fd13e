"""The bench of flaws: each machine of configs/reality logged, identified, judged, and run round a circle."""
