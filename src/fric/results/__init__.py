"""Results of verbs: each has a document, a figure, a table and a report, which the command line prints too."""
