"""The whole way in one command: from a folder of logs to a report, each step an ordinary command."""
