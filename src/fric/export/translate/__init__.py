"""Compiled steps as programs: read from their definition, written in the languages of controllers."""
