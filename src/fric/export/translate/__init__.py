"""Compiled steps as programs: read once from their definition, written in the languages of controllers."""
