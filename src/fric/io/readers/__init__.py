"""Readers of foreign log files, one format a file."""
