"""The report: one HTML file that tells what was identified, what a circle shows, and what to do about it."""
