"""The verdict: which compensation to switch on, whether that may be trusted and why not, and what to type next."""
