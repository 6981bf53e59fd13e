"""From a folder of logs to a report in one command; each step is an ordinary command."""
