"""The report: one HTML file with what was identified, what a circle shows, and what to do about it."""
