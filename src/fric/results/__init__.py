"""What verbs give: results that know document, figure, table and report. The command line prints the very same."""
