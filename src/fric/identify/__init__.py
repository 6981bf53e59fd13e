"""Identification: from records to parameters with intervals."""
