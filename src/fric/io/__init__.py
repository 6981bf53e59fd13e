"""The only place that touches files: logs, documents, outputs."""
